within RailBraking.Data;
record Drag "Resistance of the air to one car"
  extends Icons.Record;
  parameter Types.Ratio c_drag(min=0) = 0.9 "Drag coefficient";
  parameter Types.Area A_drag(min=0) = 10 "Frontal area, or this car's share of the train's";
  parameter Types.Density rho_air(min=0) = 1.2 "Density of the air";
  annotation (
    Documentation(info="<html>
<p>Parameters of <a href=\"modelica://RailBraking.Components.CarBody\">CarBody</a>.</p>
</html>"));
end Drag;
