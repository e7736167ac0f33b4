within RailBraking.FMUs;
block LateralContact "Creep, creep force and friction of a wheelset in a given lateral motion"
  extends Icons.Vehicle;
  extends Vehicles.PartialLateralWheelset;
  parameter Types.Ratio A_falling = 0.4 "Polach: friction at infinite creep speed over maximum friction";
  parameter Types.InverseVelocity B_falling = 0.2 "Polach: rate at which friction falls with creep speed";
  Interfaces.RealInput displacement(final unit="m", start=0) "Displacement of the wheelset from the middle of the track"
    annotation(Placement(transformation(extent={{-120, 73}, {-100, 93}})));
  Interfaces.RealInput lateral_velocity(final unit="m/s", start=0) "Lateral velocity"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput yaw_angle(final unit="rad", start=0) "Yaw angle"
    annotation(Placement(transformation(extent={{-120, 7}, {-100, 27}})));
  Interfaces.RealInput yaw_rate(final unit="rad/s", start=0) "Yaw rate"
    annotation(Placement(transformation(extent={{-120, -27}, {-100, -7}})));
  Interfaces.RealInput mu0(final unit="1", start=0.46) "Maximum friction coefficient"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));
  Interfaces.RealInput stiffness(final unit="1", start=1) "Creep stiffness over that of k_A and k_S"
    annotation(Placement(transformation(extent={{-120, -120}, {-100, -100}})));
  Interfaces.RealInput speed(final unit="m/s", start=25) "Speed along the track"
    annotation(Placement(transformation(extent={{-120, -93}, {-100, -73}})));
  Interfaces.RealOutput creep(final unit="1") "Total creep of each wheel"
    annotation(Placement(transformation(extent={{100, 57}, {120, 77}})));
  Interfaces.RealOutput creep_force(final unit="N") "Total creep force of each wheel"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  Interfaces.RealOutput friction(final unit="1") "Friction coefficient at the creep speed"
    annotation(Placement(transformation(extent={{100, -77}, {120, -57}})));
equation
  creep = sqrt((half_gauge*yaw_rate/speed + conicity*displacement/r_wheel)^2 + (lateral_velocity/speed - yaw_angle)^2
    + creep_small^2);
  creep_force = Q*Contact.polach(
    creep, creep*speed, Q, mu0, stiffness*factor, k_A, k_S, A_falling, B_falling);
  friction = Contact.fallingFriction(creep*speed, mu0, A_falling, B_falling);
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The contact for the states of <a
href=\"modelica://RailBraking.Predictions.LateralPrediction\">LateralPrediction</a>, for programs
that report it, so that they need no contact model of their own.
</p>
<h4>Limitations</h4>
<p>Those of the prediction. It has no states: the outputs respond at once.</p>
</html>"));
end LateralContact;
