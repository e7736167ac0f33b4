within RailBraking.Components;
model GuidedBody "Car body with six motions on two bogies"
  extends Icons.Component;
  parameter Types.Mass m(start=39000) "Mass";
  parameter Types.Inertia I_roll(start=6e4) "Inertia about the track";
  parameter Types.Inertia I_pitch(start=1.2e6) "Inertia across the track";
  parameter Types.Inertia I_yaw(start=1.2e6) "Inertia about the vertical axis";
  parameter Types.Length pivots(start=14.2) "Distance of the bogie pivots";
  parameter Types.Length h(start=0.9) "Height of the centre of gravity over the secondary suspension";
  parameter Types.Length h_frame(start=0.3)
    "Height of the secondary suspension over the centre of gravity of the frames";
  parameter Types.Length b_secondary(start=1.0) "Half the distance of the secondary springs";
  parameter Types.Stiffness k_rod(start=5e6) "Stiffness of one traction rod";
  parameter Types.Damping c_rod(start=5e4) "Damping of one traction rod";
  parameter Types.Stiffness k_y(start=1.6e5) "Lateral stiffness of one secondary spring";
  parameter Types.Stiffness k_z(start=4.3e5) "Vertical stiffness of one secondary spring";
  parameter Types.Damping c_y(start=3e4) "Lateral damping of one side";
  parameter Types.Damping c_z(start=3e4) "Vertical damping of one side";
  parameter Types.Damping c_yaw(start=1e5) "Longitudinal damping of one yaw damper";
  final parameter Types.Length arm[2] = {pivots/2, -pivots/2} "Pivots ahead of the centre";
  Interfaces.RealInput resistance(final unit="N") "Drag, positive when it slows the car"
    annotation(Placement(transformation(extent={{-120, -90}, {-100, -70}})));
  Interfaces.GuidedFlange pivot[2] "To the frames of both bogies"
    annotation(Placement(transformation(extent={{-10, -120}, {10, -100}})));
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
protected
  Types.Length position[2, 3] "x, y, z of both frames";
  Types.Angle angle[2, 3] "phi, theta, psi of both frames";
  Types.Force rod[2] "Force of both traction rods on their frames, forward";
  Types.Force lateral[2] "Force of the secondary suspension on both frames, to the left";
  Types.Force lift[2] "Force of the secondary suspension on both frames, upwards, change from static";
  Types.Torque roll[2] "Torque of the secondary suspension on both frames about the track";
  Types.Torque yaw[2] "Torque of the secondary suspension on both frames about the vertical axis";
equation
  for i in 1:2 loop
    position[i, 1] = pivot[i].x;
    position[i, 2] = pivot[i].y;
    position[i, 3] = pivot[i].z;
    angle[i, 1] = pivot[i].phi;
    angle[i, 2] = pivot[i].theta;
    angle[i, 3] = pivot[i].psi;
    rod[i] = k_rod*(x - h*theta - position[i, 1] - h_frame*angle[i, 2])
      + c_rod*(dv - h*wy - der(position[i, 1]) - h_frame*der(angle[i, 2]));
    lateral[i] = 2*k_y*(y + arm[i]*psi + h*phi - position[i, 2] + h_frame*angle[i, 1])
      + 2*c_y*(vy + arm[i]*wz + h*wx - der(position[i, 2]) + h_frame*der(angle[i, 1]));
    lift[i] = 2*k_z*(z - arm[i]*theta - position[i, 3]) + 2*c_z*(vz - arm[i]*wy - der(position[i, 3]));
    roll[i] = b_secondary^2*(2*k_z*(phi - angle[i, 1]) + 2*c_z*(wx - der(angle[i, 1])));
    yaw[i] = b_secondary^2*(2*k_y*(psi - angle[i, 3]) + 2*c_yaw*(wz - der(angle[i, 3])));
    pivot[i].X = -rod[i];
    pivot[i].Y = -lateral[i];
    pivot[i].Z = -lift[i];
    pivot[i].M_phi = h_frame*lateral[i] - roll[i];
    pivot[i].M_theta = -h_frame*rod[i];
    pivot[i].M_psi = -yaw[i];
  end for;
  der(x) = dv;
  der(y) = vy;
  der(z) = vz;
  der(phi) = wx;
  der(theta) = wy;
  der(psi) = wz;
  m*der(dv) = -rod[1] - rod[2] - resistance;
  m*der(vy) = -lateral[1] - lateral[2];
  m*der(vz) = -lift[1] - lift[2];
  I_roll*der(wx) = -roll[1] - roll[2] - h*(lateral[1] + lateral[2]);
  I_pitch*der(wy) = h*(rod[1] + rod[2]) + arm[1]*lift[1] + arm[2]*lift[2];
  I_yaw*der(wz) = -yaw[1] - yaw[2] - arm[1]*lateral[1] - arm[2]*lateral[2];
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-80, 50}, {80, -50}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Axes as in <a href=\"modelica://RailBraking.Components.GuidedWheelset\">GuidedWheelset</a>. Traction rods, springs and
dampers act at
the height of the secondary suspension.
</p>
<h4>Limitations</h4>
<p>
Rigid body, linear springs and dampers, no bump stops. The weight of the tilted body is carried by its springs alone.
</p>
</html>"));
end GuidedBody;
