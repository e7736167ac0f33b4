within RailBraking.Pneumatics;
block Rigging "Piston, levers and return spring of one brake unit"
  extends Icons.Pneumatic;
  extends Interfaces.PartialRigging;
equation
  pad_force = padForce(pressure, A_piston, i_rigging, eta_rigging, F_spring);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-60, 60}, {-60, -60}}, color={0, 0, 127}),
        Line(points={{-60, 0}, {60, 0}}, color={0, 0, 127}),
        Line(points={{60, 60}, {60, -60}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<h4>Limitations</h4>
<p>The efficiency is that of moving levers, the same in both directions.</p>
</html>"));
end Rigging;
