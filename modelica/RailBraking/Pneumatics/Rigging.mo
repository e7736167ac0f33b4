within RailBraking.Pneumatics;
block Rigging "Piston, levers and return spring of one brake unit"
  parameter Types.Area A_piston(start=0.0324) "Area of the piston";
  parameter Types.Ratio i_rigging(start=6) "Force of both pads over force of the piston";
  parameter Types.Ratio eta_rigging(start=0.95) "Efficiency of the rigging";
  parameter Types.Force F_spring(start=1200) "Force of return spring and slack adjuster";
  Interfaces.RealInput pressure(final unit="Pa") "Pressure in the cylinder";
  Interfaces.RealOutput pad_force(final unit="N") "Normal force of both pads";
equation
  pad_force = padForce(pressure, A_piston, i_rigging, eta_rigging, F_spring);
  annotation (Documentation(info="<html>
<h4>Limitations</h4>
<p>The efficiency is that of moving levers; the same in both directions. The stroke takes no air of its own and no
time.</p>
</html>"));
end Rigging;
