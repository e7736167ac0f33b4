within RailBraking.Data;
record Pad "Friction of a kind of brake pads"
  extends Icons.Record;
  parameter Types.Ratio speed_effect = 0.12 "Rise of friction from nominal speed to standstill, relative";
  parameter Types.Velocity pad_speed_nominal(min=1e-3) = 13 "Sliding speed at which friction is nominal";
  parameter Types.Ratio temperature_effect = 0.10 "Rise of friction over the temperature range, relative";
  parameter Types.Temperature temperature_nominal = 333.15 "Temperature at which friction is nominal";
  parameter Types.TemperatureDifference temperature_range(min=1e-3) = 150
    "Temperature rise at which the effect saturates";
  parameter Types.Ratio force_effect = 0.08
    "Half of the relative loss of friction from zero to twice the nominal force";
  parameter Types.Force pad_force_nominal(min=1e-3) = 56e3 "Pad force at which friction is nominal";
  parameter Types.Energy E_settle(min=1e-3) = 2e5 "Friction energy of one unit within which friction settles";
  parameter Types.Time T_settle(min=1e-3) = 3 "Time within which friction settles at low power";
  parameter Types.Force F_release(min=1e-3) = 1e3 "Pad force below which pads count as released";
  annotation (
    Documentation(info="<html>
<p>
Parameters of <a href=\"modelica://RailBraking.Friction.PadFriction\">PadFriction</a> that all groups of a train
share.
</p>
</html>"));
end Pad;
