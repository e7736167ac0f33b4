within RailBraking.Pneumatics;
block ParkingUnit "Brake unit with a parking spring that air releases"
  extends Icons.Pneumatic;
  parameter Types.Area A_piston(start=0.0324) "Area of the service piston";
  parameter Types.Ratio i_rigging(start=6) "Force of both pads over force of the piston";
  parameter Types.Ratio eta_rigging(start=0.95) "Efficiency of the rigging";
  parameter Types.Force F_spring(start=1200) "Force of return spring and slack adjuster";
  parameter Types.Force F_parking(start=8000) "Force of the parking spring at the piston";
  parameter Types.Pressure p_release(start=4.5e5) "Pressure that fully releases the parking spring";
  Interfaces.RealInput pressure(final unit="Pa") "Pressure in the service cylinder"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput parking_pressure(final unit="Pa") "Pressure in the parking cylinder"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));
  Interfaces.RealOutput pad_force(final unit="N") "Normal force of both pads"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
protected
  Types.Force service "Force of the service piston";
  Types.Force parking "Remaining force of the parking spring";
equation
  service = A_piston*pressure;
  parking = F_parking*noEvent(min(max(1 - parking_pressure/p_release, 0), 1));
  pad_force = i_rigging*eta_rigging*positivePart(noEvent(max(service, parking)) - F_spring, 1);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-60, 60}, {-60, -60}}, color={0, 0, 127}),
        Line(points={{-60, 0}, {-40, 30}, {-20, -30}, {0, 30}, {20, -30}, {40, 0}, {80, 0}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The larger of both forces acts, never their sum (anti-compound valve). A unit whose parking cylinder is vented holds the
train without air.
</p>
<h4>Limitations</h4>
<p>The force of the spring falls in proportion to the pressure against it; its stroke is not modelled.</p>
</html>"));
end ParkingUnit;
