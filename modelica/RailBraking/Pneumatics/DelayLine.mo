within RailBraking.Pneumatics;
block DelayLine "Delayed signal"
  extends Icons.Pneumatic;
  parameter Types.Time delay(min=0, start=0.4) "Delay";
  parameter Integer n(min=2) = 101 "Number of samples";
  parameter Types.Time period = 0.01 "Sampling period; make it final";
  Interfaces.RealInput u "Signal"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealOutput y "Delayed signal"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
protected
  final parameter Types.Ratio weight[n] = {max(0, 1 - abs(delay/period - i + 1)) for i in 1:n}
    "Weight of each sample, for linear interpolation";
  discrete Real line[n](each start=0, each fixed=true) "Samples, the newest first";
equation
  when sample(0.0005, period) then
    line = cat(1, {u}, pre(line[1:n - 1]));
  end when;
  y = weight*line;
initial equation
  assert(delay >= 0 and delay <= (n - 1)*period, "DelayLine: delay must be between 0 and "
    + String((n - 1)*period) + " s, got " + String(delay) + " s.");
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -50}, {0, -50}, {0, 50}, {80, 50}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
An array that is shifted at every sample. A step appears at the output after delay to delay +
period. Samples are half a millisecond off the grid of whole milliseconds, like those of <a
href=\"modelica://RailBraking.Pneumatics.ValveDelay\">ValveDelay</a>.
</p>
<h4>Limitations</h4>
<p>A pulse shorter than a period may be lost. The output is zero before the start.</p>
</html>"));
end DelayLine;
