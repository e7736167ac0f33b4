within RailBraking.Pneumatics;
block Rigging "Piston, levers and return spring of one brake unit"
  extends Icons.Pneumatic;
  parameter Types.Area A_piston(start=0.0324) "Area of the piston";
  parameter Types.Ratio i_rigging(start=6) "Force of both pads over force of the piston";
  parameter Types.Ratio eta_rigging(start=0.95) "Efficiency of the rigging";
  parameter Types.Force F_spring(start=1200) "Force of return spring and slack adjuster";
  Interfaces.RealInput pressure(final unit="Pa") "Pressure in the cylinder"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealOutput pad_force(final unit="N") "Normal force of both pads"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
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
<p>The efficiency is that of moving levers, the same in both directions. The stroke requires neither
air nor time.</p>
</html>"));
end Rigging;
