within RailBraking.Pneumatics;
partial model PartialDistributor "Distributor valve, without the share of its pressure that the relay passes on"
  extends Icons.Pneumatic;
  parameter Types.Pressure p_max = 3.8e5 "Cylinder pressure of a full brake";
  parameter Types.Time T_fill = 4 "Filling time from the first pressure to 95 % of p_max when the pipe is vented";
  parameter Types.Time T_release = 17 "Release time from p_max to 0.4 bar when the pipe is filled";
  parameter Types.Ratio inshot(min=0, max=0.9) = 0 "Share of p_max that fills at once";
  parameter Types.Pressure p_control = 5e5 "Pressure in the control reservoir: that of the released pipe";
  parameter Types.Pressure dp_full = 1.5e5 "Fall of the pipe's pressure for a full brake";
  parameter Types.Pressure dp_insensitive = 1e4 "Insensitivity: fall of the pipe's pressure without effect";
  parameter Types.Pressure p_start = 0 "Cylinder pressure at the start";
  Interfaces.AirPort pipe "Brake pipe"
    annotation(Placement(transformation(extent={{-10, 100}, {10, 120}})));
  Interfaces.AirPort supply "Auxiliary reservoir"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.AirPort outlet "Brake cylinders"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  Interfaces.RealOutput pressure(final unit="Pa") "Cylinder pressure"
    annotation(Placement(transformation(extent={{100, 50}, {120, 70}})));
protected
  constant Types.Pressure p_released = 4e4 "Cylinder pressure at which a brake counts as released";
  constant Types.Time T_relay = 0.05 "Time constant of the relay if the choke does not limit it";
  final parameter Types.PressureRate rate_fill = (0.95 - inshot)*p_max/T_fill "Of filling";
  final parameter Types.Time T_choke = T_release/log(p_max/p_released) "Time constant of the release choke";
  Types.Pressure demand "Control pressure for the pressure of the pipe";
  Types.Pressure p(start=p_start, fixed=true) "Pressure that controls the relay";
  Types.Ratio share "Cylinder pressure over the one that controls the relay";
equation
  demand = noEvent(min(p_max*min(max((p_control - pipe.p - dp_insensitive)/(dp_full - dp_insensitive), 0), 1),
    max(supply.p, p)));
  der(p) = noEvent(if demand > p and p < inshot*p_max then (demand - p)/T_relay
    elseif demand > p then min((demand - p)/T_relay, rate_fill) else max((demand - p)/T_relay,
    -p/T_choke));
  pressure = share*p;
  outlet.p = pressure;
  pipe.q = 0;
  supply.q = noEvent(max(-outlet.q, 0));
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -60}, {-40, 40}, {10, 40}, {30, 0}, {80, -50}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
A pressure that controls the relay follows the fall of the pipe's pressure in proportion, up to p_max at 1.5 bar, and
may be released in steps. Filling is at a constant rate, through a choke from a much higher pressure; release is that
of a vessel through a choke, p<sub>max</sub> e<sup>-t/T</sup>. The relay gives the cylinders <code>share</code> of it,
with air from the auxiliary reservoir, so that the times are valid for any volume. An inshot,
the initial quick step that brings the blocks to the wheel, is not limited by the choke.
</p>
<h4>Limitations</h4>
<p>
The pressure of the control reservoir is
constant, independent of the charge of the pipe.
</p>
</html>"));
end PartialDistributor;
