within RailBraking.Icons;
partial block Vehicle "Icon of a vehicle, of a part of one with several components, and of an FMU"
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid, radius=25),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Documentation(info="<html>
<p>
It has no equations.
</p>
</html>"));
end Vehicle;
