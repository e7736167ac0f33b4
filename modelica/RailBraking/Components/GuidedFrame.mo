within RailBraking.Components;
model GuidedFrame "Bogie frame with six motions between two wheelsets and the car body"
  parameter Types.Mass m(start=2600) "Mass";
  parameter Types.Inertia I_roll(start=1700) "Inertia about the track";
  parameter Types.Inertia I_pitch(start=1500) "Inertia across the track";
  parameter Types.Inertia I_yaw(start=3000) "Inertia about the vertical axis";
  parameter Types.Length wheelbase(start=2.1) "Distance of the wheelsets";
  parameter Types.Length h(start=0.15) "Height of the centre of gravity over the axles";
  parameter Types.Length b_primary(start=1.0) "Half the distance of the axle boxes";
  parameter Types.Stiffness k_x(start=3.14e7) "Longitudinal stiffness of one axle box";
  parameter Types.Stiffness k_y(start=3.88e6) "Lateral stiffness of one axle box";
  parameter Types.Stiffness k_z(start=1.22e6) "Vertical stiffness of one axle box";
  parameter Types.Damping c_x(start=1.5e4) "Longitudinal damping of one axle box";
  parameter Types.Damping c_y(start=1.5e4) "Lateral damping of one axle box";
  parameter Types.Damping c_z(start=1.2e4) "Vertical damping of one axle box";
  final parameter Types.Length arm[2] = {wheelbase/2, -wheelbase/2} "Wheelsets ahead of the centre";
  Interfaces.RealInput wheelset_position[2, 3](each final unit="m") "x, y, z of both wheelsets"
    annotation(Placement(transformation(extent={{-120, 76}, {-100, 96}})));
  Interfaces.RealInput wheelset_velocity[2, 3](each final unit="m/s") "dv, vy, vz of both wheelsets"
    annotation(Placement(transformation(extent={{-120, 47}, {-100, 67}})));
  Interfaces.RealInput wheelset_yaw[2](each final unit="rad") "psi of both wheelsets"
    annotation(Placement(transformation(extent={{-120, 19}, {-100, 39}})));
  Interfaces.RealInput wheelset_rate[2](each final unit="rad/s") "wz of both wheelsets"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealInput roll_track[2](each final unit="rad") "Roll angle of the track under both wheelsets"
    annotation(Placement(transformation(extent={{-120, -39}, {-100, -19}})));
  Interfaces.RealInput F[3](each final unit="N") "Force of the car body"
    annotation(Placement(transformation(extent={{-120, -67}, {-100, -47}})));
  Interfaces.RealInput M[3](each final unit="N.m") "Torque of the car body and of the drive, about the three axes"
    annotation(Placement(transformation(extent={{-120, -96}, {-100, -76}})));
  Interfaces.RealOutput X[2](each final unit="N") "Force on both wheelsets, forward"
    annotation(Placement(transformation(extent={{100, 70}, {120, 90}})));
  Interfaces.RealOutput Y[2](each final unit="N") "Force on both wheelsets, to the left"
    annotation(Placement(transformation(extent={{100, 30}, {120, 50}})));
  Interfaces.RealOutput N[2](each final unit="N") "Upward force of both wheelsets on the frame, change from static"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  Interfaces.RealOutput M_yaw[2](each final unit="N.m") "Torque on both wheelsets about the vertical axis"
    annotation(Placement(transformation(extent={{100, -50}, {120, -30}})));
  Interfaces.RealOutput M_roll[2](each final unit="N.m") "Torque of both wheelsets on the frame about the track"
    annotation(Placement(transformation(extent={{100, -90}, {120, -70}})));
  Types.Length x(start=0, fixed=true, nominal=1e-2) "Position along the track relative to an even run";
  Types.Velocity dv(start=0, fixed=true, nominal=1e-2) "Speed along the track, change from the start";
  Types.Length y(start=0, fixed=true, nominal=1e-3) "Lateral position, to the left";
  Types.Velocity vy(start=0, fixed=true, nominal=1e-2) "Lateral speed";
  Types.Length z(start=0, fixed=true, nominal=1e-3) "Height, change from static";
  Types.Velocity vz(start=0, fixed=true, nominal=1e-2) "Vertical speed";
  Real phi(final unit="rad", start=0, fixed=true, nominal=1e-3) "Roll angle, left side up";
  Types.AngularVelocity wx(start=0, fixed=true, nominal=1e-2) "Roll rate";
  Real theta(final unit="rad", start=0, fixed=true, nominal=1e-3) "Pitch angle, nose down";
  Types.AngularVelocity wy(start=0, fixed=true, nominal=1e-2) "Pitch rate";
  Real psi(final unit="rad", start=0, fixed=true, nominal=1e-3) "Yaw angle, to the left";
  Types.AngularVelocity wz(start=0, fixed=true, nominal=1e-2) "Yaw rate";
equation
  for i in 1:2 loop
    X[i] = 2*k_x*(x - h*theta - wheelset_position[i, 1]) + 2*c_x*(dv - h*wy - wheelset_velocity[i, 1]);
    Y[i] = 2*k_y*(y + arm[i]*psi + h*phi - wheelset_position[i, 2])
      + 2*c_y*(vy + arm[i]*wz + h*wx - wheelset_velocity[i, 2]);
    M_yaw[i] = b_primary^2*(2*k_x*(psi - wheelset_yaw[i]) + 2*c_x*(wz - wheelset_rate[i]));
    N[i] = 2*k_z*(wheelset_position[i, 3] - z + arm[i]*theta)
      + 2*c_z*(wheelset_velocity[i, 3] - vz + arm[i]*wy);
    M_roll[i] = b_primary^2*(2*k_z*(roll_track[i] - phi) - 2*c_z*wx);
  end for;
  der(x) = dv;
  der(y) = vy;
  der(z) = vz;
  der(phi) = wx;
  der(theta) = wy;
  der(psi) = wz;
  m*der(dv) = F[1] - X[1] - X[2];
  m*der(vy) = F[2] - Y[1] - Y[2];
  m*der(vz) = F[3] + N[1] + N[2];
  I_roll*der(wx) = M[1] + M_roll[1] + M_roll[2] - h*(Y[1] + Y[2]);
  I_pitch*der(wy) = M[2] + h*(X[1] + X[2]) - arm[1]*N[1] - arm[2]*N[2];
  I_yaw*der(wz) = M[3] - M_yaw[1] - M_yaw[2] - arm[1]*Y[1] - arm[2]*Y[2];
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Line(points={{-80, 10}, {80, 10}}, color={0, 0, 127}),
        Ellipse(extent={{-90, 0}, {-30, -60}}, lineColor={0, 0, 127}),
        Ellipse(extent={{30, 0}, {90, -60}}, lineColor={0, 0, 127}),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Axes as in <a href=\"modelica://RailBraking.Components.GuidedWheelset\">GuidedWheelset</a>. Linear springs and dampers
at
the axle boxes, at the height of the axles. Angles are small.
</p>
<h4>Limitations</h4>
<p>The roll of the track is not differentiated: dampers feel the roll rate of the frame alone. No bump stops, no dry
friction.</p>
</html>"));
end GuidedFrame;
