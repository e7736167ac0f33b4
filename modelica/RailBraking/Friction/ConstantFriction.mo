within RailBraking.Friction;
block ConstantFriction "Pads whose friction never changes"
  extends Interfaces.PartialPadFriction;
  parameter Types.Ratio mu_constant = 0.35 "Friction coefficient";
equation
  mu = mu_constant;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>For closed-form answers, and for studies that leave the pads out.</p>
<h4>Limitations</h4>
<p>Nothing of what makes pads interesting.</p>
</html>"));
end ConstantFriction;
