within RailBraking.Pneumatics;
model Choke "Orifice between two components"
  extends Icons.Pneumatic;
  parameter Real C(final unit="m3/(s.Pa)", start=1e-8) "Sonic conductance";
  Interfaces.AirPort a "One side"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.AirPort b "The other side"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
equation
  a.q = orificeFlow(C, a.p, b.p);
  a.q + b.q = 0;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-90, 60}, {0, 20}, {90, 60}}, color={0, 0, 127}),
        Line(points={{-90, -60}, {0, -20}, {90, -60}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>See <a href=\"modelica://RailBraking.Pneumatics.orificeFlow\">orificeFlow</a>.</p>
<h4>Limitations</h4>
<p>No volume.</p>
</html>"));
end Choke;
