within RailBraking.Pneumatics;
model RelayValve "Relay valve: air of a reservoir at a given pressure"
  extends Icons.Pneumatic;
  Interfaces.RealInput pressure(final unit="Pa") "Pressure at the outlet, if the inlet has it"
    annotation(Placement(transformation(extent={{-10, 100}, {10, 120}})));
  Interfaces.AirPort inlet "Reservoir"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.AirPort port "Outlet"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
equation
  port.p = noEvent(min(pressure, inlet.p));
  inlet.q = noEvent(max(-port.q, 0));
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Polygon(points={{-80, 40}, {-80, -40}, {0, 0}}, lineColor={0, 0, 127}),
        Polygon(points={{80, 40}, {80, -40}, {0, 0}}, lineColor={0, 0, 127}),
        Line(points={{0, 0}, {0, 90}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>The air that flows back from the outlet goes into the atmosphere.</p>
<h4>Limitations</h4>
<p>It follows at once, and has no resistance: the cylinder behind it has both.</p>
</html>"));
end RelayValve;
