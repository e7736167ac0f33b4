within RailBraking.Components;
block EddyCurrentBrake "Eddy-current brake on a disc of the axle or on the rail, with its fade-out at low speed"
  extends Icons.Component;
  parameter Types.Force F_max(start=10e3) "Maximum force at the wheels or on the rail";
  parameter Types.Velocity v_peak(min=1e-3, start=20) "Speed at which the force is at its maximum";
  parameter Types.Velocity v_full(start=16) "Speed above which the full force is available";
  parameter Types.Velocity v_end(start=14) "Speed below which no force is available";
  parameter Types.Time T = 0.2 "Time constant of the force";
  Interfaces.RealInput demand(final unit="N") "Demanded force"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput speed(final unit="m/s") "Speed of the disc at the wheel radius, or of the vehicle"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));
  Interfaces.RealOutput available(final unit="N") "Available force at this speed"
    annotation(Placement(transformation(extent={{100, 40}, {120, 60}})));
  Interfaces.RealOutput force(final unit="N") "Force, positive when braking"
    annotation(Placement(transformation(extent={{100, -60}, {120, -40}})));
protected
  Types.Force lagged(start=0, fixed=true, nominal=1e4) "Force before the limit of the available force";
equation
  available = noEvent(F_max*2*v_peak*max(speed, 0)/(v_peak^2 + speed^2)
    *min(max((speed - v_end)/(v_full - v_end), 0), 1));
  der(lagged) = (noEvent(min(max(demand, 0), available)) - lagged)/T;
  force = noEvent(min(lagged, available));
initial equation
  assert(v_full > v_end and v_end >= 0, "EddyCurrentBrake: speeds must be 0 <= v_end < v_full, got v_end = "
    + String(v_end) + " m/s and v_full = " + String(v_full) + " m/s.");
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -60}, {-50, 10}, {-10, 40}, {30, 30}, {80, 0}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<blockquote><pre>
available = F_max 2/(v/v_peak + v_peak/v) clamp((v - v_end)/(v_full - v_end), 0, 1)
</pre></blockquote>
<p>
The force of a magnet on a moving conductor (J. H. Wouterse, Critical torque and speed of eddy current brake with
widely separated soft iron poles, IEE Proceedings B 138, 1991). Connect the force of a linear brake as that of <a
href=\"modelica://RailBraking.Components.MagneticTrackBrake\">MagneticTrackBrake</a>, that of a rotating one by <a
href=\"modelica://RailBraking.Components.ShaftTorque\">ShaftTorque</a>.
</p>
<h4>Limitations</h4>
<p>Maximum force and its speed are constant: neither the heat of the conductor nor the air gap changes them. The
attraction of a linear brake does not load the wheelsets.</p>
</html>"));
end EddyCurrentBrake;
