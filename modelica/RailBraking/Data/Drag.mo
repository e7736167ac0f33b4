within RailBraking.Data;
record Drag "Resistance of the air to one car"
  parameter Types.Ratio c_drag(min=0) = 0.9 "Drag coefficient";
  parameter Types.Area A_drag(min=0) = 10 "Frontal area; of a train, this car's share of it";
  parameter Types.Density rho_air(min=0) = 1.2 "Density of the air";
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Documentation(info="<html>
<p>Parameters of <a href=\"modelica://RailBraking.Components.CarBody\">CarBody</a>.</p>
</html>"));
end Drag;
