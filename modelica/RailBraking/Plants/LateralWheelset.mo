within RailBraking.Plants;
block LateralWheelset "Conical wheelset with two halves of a torsional axle, excited laterally by the track"
  extends Icons.Vehicle;
  extends Vehicles.PartialLateralWheelset;
  parameter Types.Velocity start_speed(min=1) = 25 "Speed at the start";
  parameter Types.Inertia J[2] = {134, 64} "Inertia of right and left half of the axle with its wheel";
  parameter Types.RotationalStiffness k_torsion = 6063260 "Torsional stiffness of the axle";
  parameter Types.RotationalDamping c_torsion = 0 "Torsional damping of the axle";
  parameter Types.Ratio rolling_creep(min=0, max=1) = 1
    "1 for creepages that follow the rotation of each wheel, 0 for those of lateral and yaw motion alone";
  Interfaces.RealInput track(final unit="m", start=0) "Lateral position of the middle of the track"
    annotation(Placement(transformation(extent={{-120, 70}, {-100, 90}})));
  Interfaces.RealInput mu0(final unit="1", start=0.46) "Maximum friction coefficient"
    annotation(Placement(transformation(extent={{-120, 30}, {-100, 50}})));
  Interfaces.RealInput A_falling(final unit="1", start=0.4)
    "Polach: friction at infinite creep speed over maximum friction"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealInput B_falling(final unit="s/m", start=0.6) "Polach: rate at which friction falls with creep speed"
    annotation(Placement(transformation(extent={{-120, -50}, {-100, -30}})));
  Interfaces.RealInput motor_torque(final unit="N.m", start=0) "Torque of the motor on the right half"
    annotation(Placement(transformation(extent={{-120, -90}, {-100, -70}})));
  Interfaces.RealOutput lateral_acceleration(final unit="m/s2") = der(dy) "Lateral acceleration of the wheelset"
    annotation(Placement(transformation(extent={{102, 83}, {118, 99}})));
  Interfaces.RealOutput yaw_rate(final unit="rad/s") = dpsi "Yaw rate"
    annotation(Placement(transformation(extent={{102, 65}, {118, 81}})));
  Interfaces.RealOutput lateral_position(final unit="m") = y "Lateral position of the wheelset"
    annotation(Placement(transformation(extent={{102, 47}, {118, 63}})));
  Interfaces.RealOutput lateral_velocity(final unit="m/s") = dy "Lateral velocity of the wheelset"
    annotation(Placement(transformation(extent={{102, 28}, {118, 44}})));
  Interfaces.RealOutput yaw_angle(final unit="rad") = psi "Yaw angle"
    annotation(Placement(transformation(extent={{102, 10}, {118, 26}})));
  Interfaces.RealOutput speed(final unit="m/s") = v "Speed along the track"
    annotation(Placement(transformation(extent={{102, -8}, {118, 8}})));
  Interfaces.RealOutput wheel_speed[2](each final unit="rad/s") = w "Angular velocity of right and left wheel"
    annotation(Placement(transformation(extent={{102, -26}, {118, -10}})));
  Interfaces.RealOutput twist(final unit="rad") = theta "Angle of the right half of the axle relative to the left half"
    annotation(Placement(transformation(extent={{102, -44}, {118, -28}})));
  Interfaces.RealOutput creep[2](each final unit="1") "Total creep of right and left wheel"
    annotation(Placement(transformation(extent={{102, -63}, {118, -47}})));
  Interfaces.RealOutput creep_force[2](each final unit="N") "Total creep force of right and left wheel"
    annotation(Placement(transformation(extent={{102, -81}, {118, -65}})));
  Interfaces.RealOutput friction[2](each final unit="1")
    "Friction coefficient of right and left wheel at their creep speed"
    annotation(Placement(transformation(extent={{102, -99}, {118, -83}})));
protected
  Types.Length y(start=0, fixed=true, nominal=1e-3) "Lateral position";
  Types.Velocity dy(start=0, fixed=true, nominal=1e-2) "Lateral velocity";
  Types.Angle psi(start=0, fixed=true, nominal=1e-3) "Yaw angle";
  Types.AngularVelocity dpsi(start=0, fixed=true, nominal=1e-2) "Yaw rate";
  Types.Velocity v(start=start_speed, fixed=true, nominal=1) "Speed along the track";
  Types.AngularVelocity w[2](each start=start_speed/r_wheel, each fixed=true, each nominal=1)
    "Angular velocity of right and left wheel";
  Types.Angle theta(start=0, fixed=true, nominal=1e-4) "Twist of the axle";
  Types.Ratio steering "Longitudinal creep by yaw rate and conicity, of the right wheel";
  Types.Ratio creep_x[2] "Longitudinal creep of right and left wheel";
  Types.Ratio creep_y "Lateral creep of both wheels";
  Types.Force F_x[2] "Longitudinal force of the rail against the creep, right and left";
  Types.Force F_y[2] "Lateral force of the rail against the creep, right and left";
  Types.Torque torsion "Torque of the right half on the left half";
equation
  steering = half_gauge*dpsi/v + conicity*(y - track)/r_wheel;
  creep_x = {
    rolling_creep*(r_wheel*w[1] - v)/v + steering,
    rolling_creep*(r_wheel*w[2] - v)/v - steering};
  creep_y = dy/v - psi;
  for i in 1:2 loop
    creep[i] = sqrt(creep_x[i]^2 + creep_y^2 + creep_small^2);
    friction[i] = Contact.fallingFriction(creep[i]*v, mu0, A_falling, B_falling);
    creep_force[i] = Q*Contact.polach(creep[i], creep[i]*v, Q, mu0, factor, k_A, k_S, A_falling, B_falling);
    F_x[i] = creep_force[i]*creep_x[i]/creep[i];
    F_y[i] = creep_force[i]*creep_y/creep[i];
  end for;
  m_wheelset*der(v) = F_x[1] + F_x[2];
  der(y) = dy;
  m_unsprung*der(dy) = -F_y[1] - F_y[2];
  der(psi) = dpsi;
  I_yaw*der(dpsi) = -half_gauge*(F_x[1] - F_x[2]) - k_yaw*psi;
  torsion = k_torsion*theta + c_torsion*(w[1] - w[2]);
  J[1]*der(w[1]) = motor_torque - torsion - r_wheel*F_x[1];
  J[2]*der(w[2]) = torsion - r_wheel*F_x[2];
  der(theta) = w[1] - w[2];
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The wheelset of Mal et al. (2020), section 2. The text of the paper that was available contains the words and the
tables, but not the bodies of equations (1) to (17). The equations here are a reconstruction from the words, from
Table 1 and from the literature that the paper cites: Polach (2005) for the force at the total creep of each wheel,
which is divided in the ratio of the creep components, and Hussain and Mei (2009) for the equations of motion. The
surface is given by the inputs <code>mu0</code>, <code>A_falling</code> and <code>B_falling</code>, so that it can
change while the wheelset runs; the paper's four surfaces are in <a
href=\"modelica://RailBraking.Contact.Surfaces\">Surfaces</a>.
</p>
<p>
With <code>rolling_creep</code> = 0 the longitudinal creepages depend on yaw rate and conicity only, as the paper
describes its simplified equations (3) and (4). The contact then drives the rotation of the wheels, but the rotation
does not affect the contact: choose 1 for traction and braking.
</p>
<h4>Limitations</h4>
<p>
Those of <a href=\"modelica://RailBraking.Vehicles.PartialLateralWheelset\">PartialLateralWheelset</a>. The speed
must stay positive. The rounding of the total creep keeps the forces smooth at zero creep.
</p>
</html>"));
end LateralWheelset;
