within RailBraking.Friction;
block ConstantFriction "Pads with constant friction"
  extends Icons.Component;
  extends Interfaces.PartialPadFriction;
  parameter Types.Ratio mu_constant = 0.35 "Friction coefficient";
equation
  mu = mu_constant;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>For closed-form solutions, and for studies that do not depend on the pads.</p>
<h4>Limitations</h4>
<p>No dependence on temperature, speed, pressure or time.</p>
</html>"));
end ConstantFriction;
