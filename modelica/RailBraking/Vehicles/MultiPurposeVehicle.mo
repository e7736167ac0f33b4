within RailBraking.Vehicles;
block MultiPurposeVehicle "Instrumented car on two bogies that holds its speed on irregular track"
  extends Icons.Vehicle;
  parameter Types.Velocity speed_set = 17.88 "Speed to hold, and speed at the start";
  parameter Types.Mass m_body = 39000 "Mass of the car body";
  parameter Types.Mass m_frame = 2600 "Mass of a bogie frame";
  parameter Types.Mass m_unsprung = 1400 "Mass of a wheelset";
  parameter Types.Inertia I_body_roll = 6.0e4 "Inertia of the body in roll";
  parameter Types.Inertia I_body_pitch = 1.2e6 "Inertia of the body in pitch";
  parameter Types.Inertia I_body_yaw = 1.2e6 "Inertia of the body in yaw";
  parameter Types.Inertia I_frame_roll = 1722 "Inertia of a frame in roll";
  parameter Types.Inertia I_frame_pitch = 1476 "Inertia of a frame in pitch";
  parameter Types.Inertia I_frame_yaw = 3067 "Inertia of a frame in yaw";
  parameter Types.Inertia I_wheelset = 810 "Inertia of a wheelset in yaw";
  parameter Types.Inertia J[4] = {112, 160, 160, 112} "Inertia of the wheelsets about their axles, drive included";
  parameter Types.Length r_wheel[4] = {0.42, 0.42, 0.42, 0.42} "Rolling radius of the wheelsets";
  parameter Types.Length pivots = 14.2 "Distance of the bogie pivots";
  parameter Types.Length wheelbase = 2.1 "Distance of the wheelsets of a bogie";
  parameter Types.Ratio conicity = 0.15 "Equivalent conicity";
  parameter Types.Stiffness k_primary_x = 4e6 "Stiffness of one axle box, along the track";
  parameter Types.Stiffness k_primary_y = 5e6 "Stiffness of one axle box, across the track";
  parameter Types.Stiffness k_primary_z = 1.22e6 "Stiffness of one axle box, vertical";
  parameter Types.Damping c_primary_x = 3e4 "Damping of one axle box, along the track";
  parameter Types.Damping c_primary_y = 3e4 "Damping of one axle box, across the track";
  parameter Types.Damping c_primary_z = 1.2e4 "Damping of one axle box, vertical";
  parameter Types.Stiffness k_secondary_y = 6e5 "Stiffness of one secondary spring, across the track";
  parameter Types.Stiffness k_secondary_z = 4.3e5 "Stiffness of one secondary spring, vertical";
  parameter Types.Damping c_secondary_y = 1e5 "Damping of one side of the secondary suspension, across the track";
  parameter Types.Damping c_secondary_z = 3e4 "Damping of one side of the secondary suspension, vertical";
  parameter Types.Damping c_yaw = 1.5e6 "Damping of one yaw damper between frame and body";
  parameter Types.Stiffness k_track = 5e7 "Stiffness of the track under one wheel";
  parameter Types.Ratio k_A = 0.3 "Polach: reduction of the creep stiffness in the area of adhesion";
  parameter Types.Ratio k_S = 0.1 "Polach: reduction of the creep stiffness in the area of slip";
  parameter Types.Ratio A_falling = 0.4 "Polach: friction at infinite slip speed over maximum friction";
  parameter Types.InverseVelocity B_falling = 0.2 "Polach: rate at which friction falls with slip speed";
  parameter Types.Ratio drive_share[4] = {0, 0.5, 0.5, 0} "Share of each wheelset in the driving torque";
  parameter Types.Force resistance_rolling = 1200 "Resistance that does not depend on speed";
  parameter Real resistance_drag(final unit="N.s2/m2", min=0) = 7.0 "Drag over squared speed";
  parameter Types.Length b_box = 1.0 "Half the distance of the axle boxes";
  parameter Types.Damping gain_speed = 2e4 "Driving force over speed error";
  parameter Types.Time T_speed = 4 "Integration time of the speed controller";
  parameter Types.Time T_drive = 0.3 "Time constant of the drive";
  Interfaces.RealInput alignment[4](each final unit="m", each start=0)
    "Lateral irregularity under each wheelset, to the left"
    annotation(Placement(transformation(extent={{-120, 70}, {-100, 90}})));
  Interfaces.RealInput vertical[4](each final unit="m", each start=0)
    "Vertical irregularity under each wheelset, upwards"
    annotation(Placement(transformation(extent={{-120, 30}, {-100, 50}})));
  Interfaces.RealInput cross_level[4](each final unit="m", each start=0)
    "Left rail above right rail under each wheelset"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealInput gauge[4](each final unit="m", each start=0) "Widening of the gauge under each wheelset"
    annotation(Placement(transformation(extent={{-120, -50}, {-100, -30}})));
  Interfaces.RealInput mu0[4](each final unit="1", each start=0.3) "Maximum friction coefficient at each wheelset"
    annotation(Placement(transformation(extent={{-120, -90}, {-100, -70}})));
  Interfaces.RealOutput longitudinal_left[4](each final unit="m/s2")
    "Acceleration of the left axle boxes along the track"
    annotation(Placement(transformation(extent={{100, 79}, {120, 99}})));
  Interfaces.RealOutput longitudinal_right[4](each final unit="m/s2")
    "Acceleration of the right axle boxes along the track"
    annotation(Placement(transformation(extent={{100, 57}, {120, 77}})));
  Interfaces.RealOutput lateral[4](each final unit="m/s2")
    "Acceleration of the axle boxes across the track, to the left"
    annotation(Placement(transformation(extent={{100, 34}, {120, 54}})));
  Interfaces.RealOutput vertical_acceleration[4](each final unit="m/s2") "Acceleration of the wheelsets, upwards"
    annotation(Placement(transformation(extent={{100, 12}, {120, 32}})));
  Interfaces.RealOutput speed(final unit="m/s") "Speed of the car body"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  Interfaces.RealOutput wheelset_speed[4](each final unit="rad/s") "Angular velocity of the wheelsets"
    annotation(Placement(transformation(extent={{100, -32}, {120, -12}})));
  Interfaces.RealOutput creep[4](each final unit="1") "Total creepage of the left wheels"
    annotation(Placement(transformation(extent={{100, -54}, {120, -34}})));
  Interfaces.RealOutput offset[4](each final unit="m") "Lateral position of the wheelsets on the track, to the left"
    annotation(Placement(transformation(extent={{100, -77}, {120, -57}})));
  Interfaces.RealOutput tractive_force(final unit="N") "Force of the drive at the rims"
    annotation(Placement(transformation(extent={{100, -99}, {120, -79}})));
protected
  final parameter Types.Length b = 0.75 "Half the distance of the contacts";
  final parameter Types.Force load_nominal = g*((m_body + 2*m_frame)/4 + m_unsprung) "Load of each wheelset at rest";
  final parameter Types.Force drag_start = resistance_rolling + resistance_drag*speed_set^2
    "Resistance at the set speed";
  Components.GuidedBody body(
    m=m_body, I_roll=I_body_roll, I_pitch=I_body_pitch, I_yaw=I_body_yaw, pivots=pivots, h=0.9, h_frame=0.3,
    b_secondary=1.0, k_rod=5e6, c_rod=5e4, k_y=k_secondary_y, k_z=k_secondary_z, c_y=c_secondary_y, c_z=c_secondary_z,
    c_yaw=c_yaw) "Car body"
    annotation(Placement(transformation(extent={{-60, 20}, {-20, 60}})));
  Components.GuidedFrame frame[2](
    each m=m_frame, each I_roll=I_frame_roll, each I_pitch=I_frame_pitch, each I_yaw=I_frame_yaw,
    each wheelbase=wheelbase, each h=0.15, each b_primary=b_box, each k_x=k_primary_x, each k_y=k_primary_y,
    each k_z=k_primary_z, each c_x=c_primary_x, each c_y=c_primary_y, each c_z=c_primary_z) "Bogie frames"
    annotation(Placement(transformation(extent={{20, 20}, {60, 60}})));
  Components.GuidedWheelset wheelset[4](
    each m=m_unsprung, each I_yaw=I_wheelset, J=J, r=r_wheel, each conicity=conicity, each b=b, each k_track=k_track,
    each load_nominal=load_nominal, each k_A=k_A, each k_S=k_S, each A=A_falling, each B=B_falling,
    each start_speed=speed_set) "Wheelsets"
    annotation(Placement(transformation(extent={{-60, -60}, {-20, -20}})));
  Types.Force drive(start=drag_start, fixed=true, nominal=1e3) "Force of the drive at the rims";
  Types.Force integral(start=drag_start, fixed=true, nominal=1e3) "Integral part of the speed controller";
equation
  for i in 1:4 loop
    wheelset[i].alignment = alignment[i];
    wheelset[i].vertical = vertical[i];
    wheelset[i].cross_level = cross_level[i];
    wheelset[i].gauge = gauge[i];
    wheelset[i].mu0 = mu0[i];
    longitudinal_left[i] = wheelset[i].a - b_box*wheelset[i].a_yaw;
    longitudinal_right[i] = wheelset[i].a + b_box*wheelset[i].a_yaw;
    lateral[i] = wheelset[i].ay;
    vertical_acceleration[i] = wheelset[i].az;
    wheelset_speed[i] = wheelset[i].w;
    creep[i] = sqrt(wheelset[i].creep_x[1]^2 + wheelset[i].creep_y^2);
    offset[i] = wheelset[i].offset;
  end for;
  for k in 1:2 loop
    for j in 1:2 loop
      frame[k].drive[j] = drive*drive_share[2*k - 2 + j]*r_wheel[2*k - 2 + j];
      connect(frame[k].axle[j], wheelset[2*k - 2 + j].frame)
        annotation(Line(points={{40, 18}, {40, 0}, {-40, 0}, {-40, -18}}, color={0, 0, 127}));
    end for;
    connect(body.pivot[k], frame[k].pivot)
      annotation(Line(points={{-40, 18}, {-40, 10}, {0, 10}, {0, 80}, {40, 80}, {40, 62}}, color={0, 0, 127}));
  end for;
  body.resistance = resistance_rolling + resistance_drag*speed^2;
  der(integral) = -gain_speed/T_speed*body.dv;
  T_drive*der(drive) = integral - gain_speed*body.dv - drive;
  speed = speed_set + body.dv;
  tractive_force = drive;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-90, 40}, {90, -40}}, lineColor={0, 0, 127}),
        Ellipse(extent={{-90, -45}, {-60, -75}}, lineColor={0, 0, 127}),
        Ellipse(extent={{-55, -45}, {-25, -75}}, lineColor={0, 0, 127}),
        Ellipse(extent={{25, -45}, {55, -75}}, lineColor={0, 0, 127}),
        Ellipse(extent={{60, -45}, {90, -75}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The powered car of a multi-purpose vehicle as it ran over a friction-modified track (Abduraxman et al., 2024), for
estimators of
friction that listen to axle boxes. Inner wheelsets are driven, (1A)(A1); a PI controller holds the speed. Each
wheelset moves along,
across, about the vertical and about its axle, and bounces on the track; frames and body have six motions each.
</p>
<h4>Limitations</h4>
<p>
Masses are estimates, inertias of the running gear those of the ERRI coach; longitudinal primary, lateral secondary
and yaw damping
are chosen so that the car runs stably (all modes damped by 8 % and more) from 7 to 30 m/s on dry and on contaminated
rail: data of
the vehicle itself are not published. The second
car is left out. Those of <a href=\"modelica://RailBraking.Components.GuidedWheelset\">GuidedWheelset</a>: cones for
wheels, a simple flange.
</p>
<h4>Implementation</h4>
<p>
Its parts are <a href=\"modelica://RailBraking.Components.GuidedWheelset\">GuidedWheelset</a>, <a
href=\"modelica://RailBraking.Components.GuidedFrame\">GuidedFrame</a> and <a
href=\"modelica://RailBraking.Components.GuidedBody\">GuidedBody</a>, not Axle, Bogie and CarBody: those share one speed
along the track, have no lateral, yaw or roll motion and one contact for two wheels, and this car is all about these.
They meet in flanges of six motions.
</p>
<h4>Notes</h4>
<p>
k_A, k_S, A_falling and B_falling hold for the whole run, <code>mu0</code> may change along the track. Below 1 Hz and
at constant speed
little of friction is left in the longitudinal accelerations.
</p>
</html>"));
end MultiPurposeVehicle;
