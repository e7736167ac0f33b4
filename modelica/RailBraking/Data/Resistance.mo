within RailBraking.Data;
record Resistance "Resistance of axle bearings and rolling"
  extends Icons.Record;
  parameter Types.Ratio mu_bearing(min=1e-9) = 0.0018 "Friction coefficient of the axle bearings";
  parameter Types.Length r_bearing(min=1e-9) = 0.065 "Radius of the axle bearings";
  parameter Types.Length e_rolling = 0.0004 "Lever arm of the rolling resistance";
  annotation (
    Documentation(info="<html>
<p>
Schwarz, L&uuml;dicke and Heckmann (2019); see <a
href=\"modelica://RailBraking.Components.bearingFriction\">bearingFriction</a>.
</p>
</html>"));
end Resistance;
