within RailBraking.Pneumatics;
model CheckValve "Orifice with flow in one direction only"
  extends Icons.Pneumatic;
  parameter Real C(final unit="m3/(s.Pa)", start=1e-8) "Sonic conductance";
  Interfaces.AirPort a "From here"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.AirPort b "To there"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
equation
  a.q = orificeFlow(C, noEvent(max(a.p, b.p)), b.p);
  a.q + b.q = 0;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Polygon(points={{-40, 40}, {40, 0}, {-40, -40}}, lineColor={0, 0, 127}),
        Line(points={{40, 40}, {40, -40}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<h4>Limitations</h4>
<p>No opening pressure, no leak.</p>
</html>"));
end CheckValve;
