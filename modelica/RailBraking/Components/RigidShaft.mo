within RailBraking.Components;
block RigidShaft "Wheels and brake discs as one"
  extends Icons.Component;
  extends Interfaces.PartialShaft;
equation
  J_braked = J_total;
  w_wheel = w;
  tau = tau_wheel;
  energy = J_total*w^2/2;
  loss = 0;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<h4>Limitations</h4>
<p>See <a href=\"modelica://RailBraking.Components.ElasticShaft\">ElasticShaft</a> for shafts that twist.</p>
</html>"));
end RigidShaft;
