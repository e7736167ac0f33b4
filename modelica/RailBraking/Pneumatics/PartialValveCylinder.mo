within RailBraking.Pneumatics;
partial block PartialValveCylinder "Cylinders that valves fill, hold and vent, from any supply"
  extends Icons.Pneumatic;
  extends Interfaces.PartialCylinder(command(final unit="1"));
  parameter Types.Time T_fill = 0.4 "Time constant of filling";
  parameter Types.Time T_vent = 0.2 "Time constant of venting";
  parameter Types.PressureRate rate_choked = 15e5 "Fastest venting, through a choked valve";
  parameter Types.PressureRate leak = 1e3 "Loss of pressure through leaks";
  parameter Types.Time dead_fill = 0.05 "Dead time of the fill valve";
  parameter Types.Time dead_vent = 0.04 "Dead time of the vent valve";
  Interfaces.RealOutput rate(final unit="Pa/s") "Rate of the pressure"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  ValveDelay valves(dead_fill=dead_fill, dead_vent=dead_vent) "Dead time of the valves"
    annotation(Placement(transformation(extent={{-20, -20}, {20, 20}})));
protected
  final parameter Types.Pressure p_small = 1e4 "Pressure below which a leak fades";
  Types.Pressure p(start=p_start, fixed=true) "Pressure in the cylinders";
  Types.Pressure dp_fill "Pressure of the supply above that of the cylinders";
  Types.PressureRate rate_fill "Rate through the fill valve";
  Types.PressureRate rate_vent "Rate through the vent valve";
equation
  valves.command = command;
  rate_fill = valves.filling*dp_fill/T_fill;
  rate_vent = valves.venting*p/T_vent/(1 + (p/(T_vent*rate_choked))^8)^0.125;
  rate = rate_fill - rate_vent - leak*p/(p + p_small);
  der(p) = rate;
  pressure = p;
  air_flow = V/p_free*noEvent(max(rate_fill, 0));
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-70, 40}, {70, -40}}, lineColor={0, 0, 127}),
        Line(points={{-10, 40}, {-10, -40}}, color={0, 0, 127}),
        Line(points={{-10, 0}, {90, 0}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The command is -1 vent, 0 hold, +1 fill, with thresholds at &plusmn;0.5 and the dead times of
<a href=\"modelica://RailBraking.Pneumatics.ValveDelay\">ValveDelay</a>. Filling approaches the supply
pressure, venting the atmosphere,
both as first-order lags; at high pressure venting is choked and limited to
<code>rate_choked</code>. Air is counted at the fill valve: air that the vent valve releases at the
same time, and leakage, must be refilled.
</p>
<p>
Typical values (engineering estimates after published valve and test-rig data): dead time 20 to 100 ms, T_vent 0.15 to
0.35 s,
T_fill 0.25 to 0.7 s, leak up to 5 kPa/s.
</p>
<h4>Limitations</h4>
<p>
The build-up of an emergency brake
upstream of the valves (some 0.4 s dead time, 0.5 s time constant) must be in the command. The
rounding of the choke reduces the rate by 8 % where both limits are equal.
</p>
</html>"));
end PartialValveCylinder;
