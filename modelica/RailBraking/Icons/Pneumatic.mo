within RailBraking.Icons;
partial block Pneumatic "Icon of a component that stores or conducts air"
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid, lineThickness=0.5),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Documentation(info="<html>
<p>
It has no equations.
</p>
</html>"));
end Pneumatic;
