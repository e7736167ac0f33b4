within RailBraking.Components;
block ElectrodynamicBrake "Electrodynamic brake with its limits of force, power and low speed"
  extends Icons.Component;
  parameter Types.Force F_max(start=60e3) "Largest force at the wheels";
  parameter Types.Power P_max(start=1e6) "Largest power at the wheels";
  parameter Types.Velocity v_full(start=3) "Speed down to which it brakes fully";
  parameter Types.Velocity v_end(start=1) "Speed below which it does not brake";
  parameter Types.Time T = 0.2 "Time constant of the force";
  Interfaces.RealInput demand(final unit="N") "Force that is asked of it"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput speed(final unit="m/s") "Speed of the vehicle"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));
  Interfaces.RealOutput available(final unit="N") "Most that it can give at this speed"
    annotation(Placement(transformation(extent={{100, 40}, {120, 60}})));
  Interfaces.RealOutput force(final unit="N") "Force at the wheels, positive when braking"
    annotation(Placement(transformation(extent={{100, -60}, {120, -40}})));
protected
  Types.Force lagged(start=0, fixed=true) "Force, without the limits of the moment";
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
Constant force, then constant power, and a straight fade-out before standstill. The force follows its demand with a
lag and never exceeds what is
available. Fade-outs of multiple units lie between 10 and 3 km/h (estimated).
</p>
<h4>Limitations</h4>
<p>Whether line or resistor takes the power is not asked. The field of the motors at high speed is P_max/v, not
falling faster.</p>
</html>"));
end ElectrodynamicBrake;
