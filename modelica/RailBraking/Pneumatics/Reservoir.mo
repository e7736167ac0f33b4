within RailBraking.Pneumatics;
model Reservoir "Reservoir of compressed air"
  extends Icons.Pneumatic;
  parameter Types.Volume V(min=1e-6, start=0.1) "Volume";
  parameter Types.Pressure p_start = 0 "Pressure at the start";
  Interfaces.AirPort port "Air"
    annotation(Placement(transformation(extent={{-10, -120}, {10, -100}})));
  Interfaces.RealOutput pressure(final unit="Pa") "Pressure"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
protected
  Types.Pressure p(start=p_start, fixed=true) "Pressure";
equation
  V/p_free*der(p) = port.q;
  port.p = p;
  pressure = p;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Ellipse(extent={{-80, 40}, {80, -40}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>V dp/dt = p_free q: the temperature is that of the surroundings.</p>
<h4>Limitations</h4>
<p>
Isothermal. A reservoir that is emptied within seconds cools down: its pressure drop is at first up
to a third larger than after it has warmed up again (adiabatic: 1.4 times).
</p>
</html>"));
end Reservoir;
