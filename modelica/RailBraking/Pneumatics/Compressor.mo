within RailBraking.Pneumatics;
model Compressor "Compressor that controls a pressure between two limits"
  extends Icons.Pneumatic;
  parameter Types.VolumeFlow q_nominal(start=0.02) "Free air that it delivers while it runs";
  parameter Types.Pressure p_in = 8.5e5 "Pressure at which it starts";
  parameter Types.Pressure p_out = 10e5 "Pressure at which it stops";
  parameter Boolean running_start = false "= true, if it runs at the start";
  Interfaces.AirPort port "Delivery"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  Interfaces.RealOutput running(final unit="1") "1 while it runs, else 0"
    annotation(Placement(transformation(extent={{100, 50}, {120, 70}})));
protected
  discrete Real on(start=if running_start then 1 else 0, fixed=true) "1 while it runs";
equation
  when {port.p < p_in, port.p > p_out} then
    on = if port.p < (p_in + p_out)/2 then 1 else 0;
  end when;
  running = on;
  port.q = -on*q_nominal;
initial equation
  assert(p_out > p_in, "Compressor: p_out must be above p_in, got " + String(p_out) + " Pa and "
    + String(p_in) + " Pa.");
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Ellipse(extent={{-60, 60}, {60, -60}}, lineColor={0, 0, 127}),
        Line(points={{-45, 40}, {58, 14}}, color={0, 0, 127}),
        Line(points={{-45, -40}, {58, -14}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>Screw and piston compressors of multiple units deliver 0.5 to 2 m&sup3;/min and control the
pressure between 8.5 and 10 bar (estimated).</p>
<h4>Limitations</h4>
<p>Delivery does not fall with the pressure, and there is neither dryer nor cooler nor duty cycle.</p>
</html>"));
end Compressor;
