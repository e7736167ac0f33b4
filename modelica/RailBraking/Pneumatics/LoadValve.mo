within RailBraking.Pneumatics;
block LoadValve "Pressure in proportion to the load"
  extends Icons.Pneumatic;
  parameter Types.Mass m_tare(start=40000) "Load at and below which the pressure is lowest";
  parameter Types.Mass m_laden(start=50000) "Load at and above which the pressure is the demand";
  parameter Types.Ratio share_tare(min=0, max=1, start=0.8) "Share of the demand at and below m_tare";
  Interfaces.RealInput demand(final unit="Pa") "Pressure of a laden vehicle"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput load(final unit="kg") "Load that the suspension carries"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));
  Interfaces.RealOutput pressure(final unit="Pa") "Pressure for the load"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
equation
  pressure = demand*(share_tare + (1 - share_tare)*noEvent(min(max((load - m_tare)/(m_laden - m_tare), 0), 1)));
initial equation
  assert(m_laden > m_tare, "LoadValve: m_laden must be above m_tare, got " + String(m_laden) + " kg and "
    + String(m_tare) + " kg.");
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -40}, {-40, -40}, {40, 40}, {80, 40}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<blockquote><pre>
pressure = demand (share_tare + (1 - share_tare) (load - m_tare)/(m_laden - m_tare))
</pre></blockquote>
<p>
between the two loads, and constant beyond them. With share_tare = m_tare/m_laden the deceleration is
the same at each
load between.
</p>
<h4>Limitations</h4>
<p>
No delay. In service the pressure of the air springs is damped, so that pitching does not affect the
brake: connect the mass, not the instantaneous force.
</p>
</html>"));
end LoadValve;
