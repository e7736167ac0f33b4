within RailBraking.Pneumatics;
block DelayLine "Signal as it was a while ago"
  extends Icons.Pneumatic;
  parameter Types.Time delay(min=0, start=0.4) "How long ago";
  parameter Integer n(min=2) = 101 "Samples that are kept";
  parameter Types.Time period = 0.01 "Between samples; make it final";
  Interfaces.RealInput u "Signal"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealOutput y "Signal as it was"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
protected
  final parameter Types.Ratio weight[n] = {max(0, 1 - abs(delay/period - i + 1)) for i in 1:n}
    "Of each sample: straight between the two nearest ones";
  discrete Real line[n](each start=0, each fixed=true) "Samples, the newest first";
equation
  when sample(0.0005, period) then
    line = cat(1, {u}, pre(line[1:n - 1]));
  end when;
  y = weight*line;
initial equation
  assert(delay >= 0 and delay <= (n - 1)*period, "DelayLine: delay must lie between 0 and "
    + String((n - 1)*period) + " s, got " + String(delay) + " s.");
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -50}, {0, -50}, {0, 50}, {80, 50}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
An ordinary array that moves on at every sample. A signal that jumps comes out delay to delay + period later.
Samples lie half a millisecond off
the grid of whole milliseconds, as those of <a href=\"modelica://RailBraking.Pneumatics.ValveDelay\">ValveDelay</a>.
</p>
<h4>Limitations</h4>
<p>What lasts less than a period may be lost. Zero before the start.</p>
</html>"));
end DelayLine;
