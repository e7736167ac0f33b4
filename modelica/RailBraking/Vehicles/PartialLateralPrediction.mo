within RailBraking.Vehicles;
partial block PartialLateralPrediction "Lateral and yaw dynamics with friction as a random walk"
  extends Icons.Vehicle;
  extends PartialLateralWheelset;
  parameter Types.Ratio mu0_start = 0.25 "Maximum friction coefficient at the start";
  parameter Types.Ratio A_falling = 0.4 "Polach: friction at infinite creep speed over maximum friction";
  parameter Types.InverseVelocity B_falling = 0.2 "Polach: rate at which friction falls with creep speed";
  Interfaces.RealInput speed(final unit="m/s", start=25) "Speed along the track"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealOutput lateral_acceleration(final unit="m/s2") = der(dy) "Reading of the accelerometer"
    annotation(Placement(transformation(extent={{100, 40}, {120, 60}})));
  Interfaces.RealOutput yaw_rate(final unit="rad/s") = dpsi "Reading of the gyroscope"
    annotation(Placement(transformation(extent={{100, -60}, {120, -40}})));
  Types.Length y(start=0, fixed=true, nominal=1e-3, stateSelect=StateSelect.always) "Lateral position";
  Types.Velocity dy(start=0, fixed=true, nominal=1e-2, stateSelect=StateSelect.always) "Lateral velocity";
  Types.Angle psi(start=0, fixed=true, nominal=1e-3, stateSelect=StateSelect.always) "Yaw angle";
  Types.AngularVelocity dpsi(start=0, fixed=true, nominal=1e-2, stateSelect=StateSelect.always) "Yaw rate";
  Real log_mu0(final unit="1", start=log(mu0_start), fixed=true, nominal=1, stateSelect=StateSelect.always)
    "Natural logarithm of the maximum friction coefficient";
protected
  Types.Ratio stiffness = 1 "Creep stiffness over that of k_A and k_S";
  Types.Ratio mu0 "Maximum friction coefficient";
  Types.Length displacement "Displacement of the wheelset from the middle of the track";
  Types.Ratio creep_x "Longitudinal creep of the right wheel";
  Types.Ratio creep_y "Lateral creep of both wheels";
  Types.Ratio creep "Total creep of each wheel";
  Types.Force F_over_creep "Total creep force of a wheel over its creep";
equation
  mu0 = exp(log_mu0);
  creep_x = half_gauge*dpsi/speed + conicity*displacement/r_wheel;
  creep_y = dy/speed - psi;
  creep = sqrt(creep_x^2 + creep_y^2 + creep_small^2);
  F_over_creep = Q*Contact.polach(
    creep, creep*speed, Q, mu0, stiffness*factor, k_A, k_S, A_falling, B_falling)/creep;
  der(y) = dy;
  m_unsprung*der(dy) = -2*F_over_creep*creep_y;
  der(psi) = dpsi;
  I_yaw*der(dpsi) = -2*half_gauge*F_over_creep*creep_x - k_yaw*psi;
  der(log_mu0) = 0;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -40}, {-30, 30}, {20, 0}, {80, 50}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Creep and creep force are algebraic; only readings change friction. Its logarithm is the state,
because the force is the same for a friction of either sign: a filter that overshoots zero would
remain on the wrong side with a small variance. Free of events. Extending classes define
<code>displacement</code>, and may replace the constant <code>stiffness</code>.
</p>
<h4>Limitations</h4>
<p>
Without traction, braking and torsion of the axle: both wheels have the same creep, and longitudinal creep from braking
or traction appears as lower friction. A and B of the falling friction are fixed: at the creeps of running on straight
track, up to 0.003, they change the friction by less than 4 %.
</p>
</html>"));
end PartialLateralPrediction;
