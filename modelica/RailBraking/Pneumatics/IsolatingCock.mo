within RailBraking.Pneumatics;
model IsolatingCock "Cock that shuts a brake unit off and vents it"
  extends Icons.Pneumatic;
  parameter Boolean isolated = false "= true, if it is closed";
  parameter Real C(final unit="m3/(s.Pa)", start=4e-8) "Sonic conductance of the open cock and of the vent";
  Interfaces.AirPort a "Supply"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.AirPort b "Brake unit"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
equation
  a.q = if isolated then 0 else orificeFlow(C, a.p, b.p);
  b.q = if isolated then orificeFlow(C, b.p, 0) else -a.q;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Ellipse(extent={{-40, 40}, {40, -40}}, lineColor={0, 0, 127}),
        Line(points={{-100, 0}, {-40, 0}}, color={0, 0, 127}),
        Line(points={{40, 0}, {100, 0}}, color={0, 0, 127}),
        Line(points={{0, 40}, {0, -40}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
A unit that does not release is isolated by hand; the others of its car continue to brake. The unit is isolated during
the whole simulation.
</p>
<h4>Limitations</h4>
<p>It cannot be turned during the simulation.</p>
</html>"));
end IsolatingCock;
