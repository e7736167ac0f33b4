within RailBraking.Interfaces;
partial block PartialPadFriction "Friction coefficient between the pads and the disc of one group"
  RealInput pad_force(final unit="N") "Normal force of both pads of one brake unit together"
    annotation(Placement(transformation(extent={{-120, 57}, {-100, 77}})));
  RealInput pad_speed(final unit="m/s") "Sliding speed of the pads"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  RealInput temperature(final unit="K") "Temperature of the disc"
    annotation(Placement(transformation(extent={{-120, -77}, {-100, -57}})));
  RealOutput mu(final unit="1") "Friction coefficient"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>One coefficient stands for all brake units of a group.</p>
</html>"));
end PartialPadFriction;
