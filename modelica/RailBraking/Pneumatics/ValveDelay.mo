within RailBraking.Pneumatics;
block ValveDelay "Dead time of a fill and a vent valve that share a three-state command"
  extends Icons.Pneumatic;
  parameter Types.Time dead_fill = 0.05 "Dead time of the fill valve";
  parameter Types.Time dead_vent = 0.04 "Dead time of the vent valve";
  constant Types.Time period = 0.002 "Resolution of the dead times";
  constant Types.Time offset = 0.0005
    "First sample; half a communication step of 1 ms, so that no step ends on a sample";
  Interfaces.RealInput command(start=0) "At or below -0.5 vent, at or above 0.5 fill, hold between"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealOutput filling(final unit="1") "1 while the fill valve is open, else 0"
    annotation(Placement(transformation(extent={{100, 40}, {120, 60}})));
  Interfaces.RealOutput venting(final unit="1") "1 while the vent valve is open, else 0"
    annotation(Placement(transformation(extent={{100, -60}, {120, -40}})));
protected
  constant Integer n = 64 "Number of commands that are stored";
  final parameter Types.Ratio weight_fill[n] = delayWeights(dead_fill/period, n)
    "Weight of each command for the fill valve, for linear interpolation";
  final parameter Types.Ratio weight_vent[n] = delayWeights(dead_vent/period, n)
    "Weight of each command for the vent valve";
  discrete Real line[n](each start=0, each fixed=true) "Commands as sampled every period, the newest first";
  discrete Real fill_open(start=0, fixed=true) "1 while the fill valve is open";
  discrete Real vent_open(start=0, fixed=true) "1 while the vent valve is open";
equation
  when sample(offset, period) then
    line = cat(1, {if command >= 0.5 then 1 elseif command <= -0.5 then -1 else 0}, pre(line[1:n - 1]));
    fill_open = if weight_fill*line >= 0.5 then 1 else 0;
    vent_open = if weight_vent*line <= -0.5 then 1 else 0;
  end when;
  filling = fill_open;
  venting = vent_open;
initial equation
  assert(dead_fill >= 0 and dead_fill <= 63*period,
    "ValveDelay: dead_fill must be between 0 and 0.126 s, got " + String(dead_fill) + " s.");
  assert(dead_vent >= 0 and dead_vent <= 63*period,
    "ValveDelay: dead_vent must be between 0 and 0.126 s, got " + String(dead_vent) + " s.");
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -50}, {0, -50}, {0, 50}, {80, 50}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
A delay line, sampled every 2 ms: any number of commands may be pending, and the length of a pulse
does not depend on the dead time. Between two samples the line is interpolated. The samples are half
a millisecond off the grid of whole milliseconds, on which simulation tools usually exchange inputs
and outputs: if a sample and the end of a communication step differed by rounding only, a tool would
have to integrate over some 1e-18 s, which not every solver can. Choose communication steps that do
not end on a sample, such as whole milliseconds.
</p>
<p>
A valve opens and closes with the same dead time. Dead times are rounded to the resolution; a command that changes
between two samples acts up to 2 ms later.
</p>
<h4>Limitations</h4>
<p>
Dead times up to 126 ms. A pulse shorter than 2 ms may be missed; real valves miss pulses below some 20 ms. With
unequal dead times both
valves may be open at once for their difference, which costs air, as in service.
</p>
</html>"));
end ValveDelay;
