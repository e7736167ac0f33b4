within RailBraking.Components;
block ElectrodynamicBrake "Electrodynamic brake with its limits of force, power and low speed"
  extends Icons.Component;
  parameter Types.Force F_max(start=60e3) "Maximum force at the wheels";
  parameter Types.Power P_max(start=1e6) "Maximum power at the wheels";
  parameter Types.Velocity v_full(start=3) "Speed above which the full force is available";
  parameter Types.Velocity v_end(start=1) "Speed below which no force is available";
  parameter Types.Time T = 0.2 "Time constant of the force";
  Interfaces.RealInput demand(final unit="N") "Demanded force"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput speed(final unit="m/s") "Speed of the vehicle"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));
  Interfaces.RealOutput available(final unit="N") "Available force at this speed"
    annotation(Placement(transformation(extent={{100, 40}, {120, 60}})));
  Interfaces.RealOutput force(final unit="N") "Force at the wheels, positive when braking"
    annotation(Placement(transformation(extent={{100, -60}, {120, -40}})));
protected
  Types.Force lagged(start=0, fixed=true, nominal=1e4) "Force before the limit of the available force";
equation
  available = noEvent(min(F_max, P_max/max(speed, 1e-3))*min(max((speed - v_end)/(v_full - v_end), 0), 1));
  der(lagged) = (noEvent(min(max(demand, 0), available)) - lagged)/T;
  force = noEvent(min(lagged, available));
initial equation
  assert(v_full > v_end and v_end >= 0, "ElectrodynamicBrake: speeds must be 0 <= v_end < v_full, got v_end = "
    + String(v_end) + " m/s and v_full = " + String(v_full) + " m/s.");
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -60}, {-60, 40}, {0, 40}, {30, 5}, {80, -20}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<blockquote><pre>
available = min(F_max, P_max/v) clamp((v - v_end)/(v_full - v_end), 0, 1)
</pre></blockquote>
<p>
Constant force, then constant power, and a linear fade-out before standstill. The force follows its
demand with a lag and never exceeds the available force. Multiple units fade out between 10 and 3
km/h (estimated).
</p>
<h4>Limitations</h4>
<p>It is not distinguished whether line or resistor takes the power. The force at high speed is
P_max/v; a faster decrease by field weakening is not modelled.</p>
</html>"));
end ElectrodynamicBrake;
