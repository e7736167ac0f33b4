within RailBraking.Pneumatics;
model Distributor "Distributor valve with relay: from the pressure of the brake pipe to that of the cylinders"
  parameter Types.Pressure p_max = 3.8e5 "Cylinder pressure of a full brake";
  parameter Types.Time T_fill = 4 "From the first pressure to 95 % of p_max when the pipe is vented";
  parameter Types.Time T_release = 17 "From p_max to 0.4 bar when the pipe is filled";
  parameter Types.Pressure p_control = 5e5 "Pressure in the control reservoir: that of the released pipe";
  parameter Types.Pressure dp_full = 1.5e5 "Fall of the pipe's pressure for a full brake";
  parameter Types.Pressure dp_insensitive = 1e4 "Fall of the pipe's pressure that does nothing";
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
  constant Types.Pressure p_released = 4e4 "At which a brake counts as released";
  constant Types.Time T_relay = 0.05 "In which the relay follows where the choke does not hold it";
  final parameter Types.PressureRate rate_fill = 0.95*p_max/T_fill "Of filling";
  final parameter Types.Time T_choke = T_release/log(p_max/p_released) "Time constant of the release choke";
  Types.Pressure demand "Cylinder pressure for that of the pipe";
  Types.Pressure p(start=p_start, fixed=true) "Cylinder pressure";
equation
  demand = noEvent(min(p_max*min(max((p_control - pipe.p - dp_insensitive)/(dp_full - dp_insensitive), 0), 1),
    max(supply.p, p)));
  der(p) = noEvent(if demand > p then min((demand - p)/T_relay, rate_fill) else max((demand - p)/T_relay,
-p/T_choke));
  pressure = p;
  outlet.p = p;
  pipe.q = 0;
  supply.q = noEvent(max(-outlet.q, 0));
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Line(points={{-80, -60}, {-40, 40}, {10, 40}, {30, 0}, {80, -50}}, color={0, 0, 127}),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The cylinder pressure follows the fall of the pipe's pressure in proportion, up to p_max at 1.5 bar, and may be
released in steps. Filling is at a
constant rate, through a choke from a much higher pressure; release is that of a vessel through a choke,
p<sub>max</sub> e<sup>-t/T</sup>.
</p>
<table border=\"1\">
<tr><th>position</th><th>filling to 95 %</th><th>release to 0.4 bar</th></tr>
<tr><td>P, passenger</td><td>3 to 5 s</td><td>15 to 20 s</td></tr>
<tr><td>R, rapid: as P, at a higher p_max or braked weight</td><td>3 to 5 s</td><td>15 to 20 s</td></tr>
<tr><td>G, goods</td><td>18 to 30 s</td><td>45 to 60 s</td></tr>
</table>
<p>
Limits of UIC 540 (5th edition, 2006; EN 15355), for one vehicle whose pipe is vented or filled at once; the
default is their middle. A relay
gives the cylinders what they take from the auxiliary reservoir, so that the times hold for any volume.
</p>
<h4>Limitations</h4>
<p>
No first quick step that brings the pads to the disc, no acceleration of the pipe, and no two stages of R by speed.
The control reservoir keeps its
pressure, whatever the pipe was charged with.
</p>
</html>"));
end Distributor;
