within RailBraking.Interfaces;
partial block PartialPadFriction "Friction coefficient between the pads and the disc of one group"
  extends Icons.Component;
  parameter Types.Ratio mu_nominal = 0.35 "Friction at the nominal speed, pressure and temperature";
  parameter Types.Ratio speed_effect = 0.12 "Rise of friction from nominal speed to standstill, relative";
  parameter Types.Velocity pad_speed_nominal = 13 "Sliding speed at which friction is nominal";
  parameter Types.Ratio temperature_effect = 0.10 "Rise of friction over the temperature range, relative";
  parameter Types.Temperature temperature_nominal = 333.15 "Temperature at which friction is nominal";
  parameter Types.TemperatureDifference temperature_range = 150 "Temperature rise at which the effect saturates";
  parameter Types.Ratio force_effect = 0.08
    "Half of the relative loss of friction from zero to twice the nominal force";
  parameter Types.Force pad_force_nominal = 56e3 "Pad force at which friction is nominal";
  parameter Types.Energy E_settle = 2e5 "Friction energy of one unit within which friction settles";
  parameter Types.Time T_settle = 3 "Time within which friction settles at low power";
  parameter Types.Force F_release = 1e3 "Pad force below which pads count as released";
  parameter Types.Ratio mu_start = 0.35 "Friction at the start";
  RealInput pad_force(final unit="N") "Normal force of both pads of one brake unit together"
    annotation(Placement(transformation(extent={{-120, 57}, {-100, 77}})));
  RealInput pad_speed(final unit="m/s") "Sliding speed of the pads"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  RealInput temperature(final unit="K") "Temperature of the disc"
    annotation(Placement(transformation(extent={{-120, -77}, {-100, -57}})));
  RealOutput mu(final unit="1") "Friction coefficient"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
One coefficient represents all brake units of a group. The parameters are those of <a
href=\"modelica://RailBraking.Friction.PadFriction\">PadFriction</a>; another law may ignore them
and have its own.
</p>
</html>"));
end PartialPadFriction;
