within RailBraking.Friction;
block ConstantFriction "Pads whose friction never changes"
  extends Icons.Component;
  extends Interfaces.PartialPadFriction;
  parameter Types.Ratio mu_constant = 0.35 "Friction coefficient";
equation
  mu = mu_constant;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>For closed-form answers, and for studies that leave the pads out.</p>
<h4>Limitations</h4>
<p>Nothing of what makes pads interesting.</p>
</html>"));
end ConstantFriction;
