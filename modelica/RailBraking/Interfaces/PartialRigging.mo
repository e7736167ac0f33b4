within RailBraking.Interfaces;
partial block PartialRigging "Piston, levers and return spring of one brake unit"
  extends Icons.Component;
  parameter Types.Area A_piston(start=0.0324) "Area of the piston";
  parameter Types.Ratio i_rigging(start=6) "Force of both pads over force of the piston";
  parameter Types.Ratio eta_rigging(start=0.95) "Mean efficiency of the rigging";
  parameter Types.Force F_spring(start=1200) "Force of return spring and slack adjuster";
  RealInput pressure(final unit="Pa") "Pressure in the cylinder"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  RealOutput pad_force(final unit="N") "Normal force of both pads"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>The stroke requires neither air nor time.</p>
</html>"));
end PartialRigging;
