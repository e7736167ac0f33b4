within RailBraking.Icons;
partial model Validation "Icon of a model that asserts a known answer"
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Line(points={{-60, 0}, {-20, -50}, {60, 60}}, color={0, 0, 127}, thickness=0.5),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Documentation(info="<html>
<p>
It has no equations.
</p>
</html>"));
end Validation;
