within RailBraking.Data;
record Resistance "Resistance of axle bearings and rolling"
  parameter Types.Ratio mu_bearing(min=1e-9) = 0.0018 "Friction coefficient of the axle bearings";
  parameter Types.Length r_bearing(min=1e-9) = 0.065 "Radius of the axle bearings";
  parameter Types.Length e_rolling = 0.0004 "Lever arm of the rolling resistance";
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Documentation(info="<html>
<p>
Schwarz, L&uuml;dicke and Heckmann (2019); see <a
href=\"modelica://RailBraking.Components.bearingFriction\">bearingFriction</a>.
</p>
</html>"));
end Resistance;
