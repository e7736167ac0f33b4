within RailBraking.Components;
model GuidedFrame "Bogie frame with six motions between two wheelsets and the car body"
  extends Icons.Component;
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
  Interfaces.RealInput drive[2](each final unit="N.m") "Torque of the frame's drive on each axle, forward"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.GuidedFlange axle[2] "Axle boxes of both wheelsets"
    annotation(Placement(transformation(extent={{-10, -120}, {10, -100}})));
  Interfaces.GuidedFlange pivot "To a car body"
    annotation(Placement(transformation(extent={{-10, 100}, {10, 120}})));
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
  Types.Length position[2, 3] "x, y, z of both wheelsets";
  Types.Angle yaw[2] "psi of both wheelsets";
equation
  for i in 1:2 loop
    position[i, 1] = axle[i].x;
    position[i, 2] = axle[i].y;
    position[i, 3] = axle[i].z;
    yaw[i] = axle[i].psi;
    axle[i].X = -2*k_x*(x - h*theta - position[i, 1]) - 2*c_x*(dv - h*wy - der(position[i, 1]));
    axle[i].Y = -2*k_y*(y + arm[i]*psi + h*phi - position[i, 2]) - 2*c_y*(vy + arm[i]*wz + h*wx - der(position[i, 2]));
    axle[i].Z = 2*k_z*(position[i, 3] - z + arm[i]*theta) + 2*c_z*(der(position[i, 3]) - vz + arm[i]*wy);
    axle[i].M_phi = b_primary^2*(2*k_z*(axle[i].phi - phi) - 2*c_z*wx);
    axle[i].M_theta = -drive[i];
    axle[i].M_psi = -b_primary^2*(2*k_x*(psi - yaw[i]) + 2*c_x*(wz - der(yaw[i])));
  end for;
  pivot.x = x;
  pivot.y = y;
  pivot.z = z;
  pivot.phi = phi;
  pivot.theta = theta;
  pivot.psi = psi;
  der(x) = dv;
  der(y) = vy;
  der(z) = vz;
  der(phi) = wx;
  der(theta) = wy;
  der(psi) = wz;
  m*der(dv) = pivot.X + axle[1].X + axle[2].X;
  m*der(vy) = pivot.Y + axle[1].Y + axle[2].Y;
  m*der(vz) = pivot.Z + axle[1].Z + axle[2].Z;
  I_roll*der(wx) = pivot.M_phi + axle[1].M_phi + axle[2].M_phi + h*(axle[1].Y + axle[2].Y);
  // The drive is mounted on the frame: a torque that turns the axles forward lifts the nose.
  I_pitch*der(wy) = pivot.M_theta + axle[1].M_theta + axle[2].M_theta - h*(axle[1].X + axle[2].X)
    - arm[1]*axle[1].Z - arm[2]*axle[2].Z;
  I_yaw*der(wz) = pivot.M_psi + axle[1].M_psi + axle[2].M_psi + arm[1]*axle[1].Y + arm[2]*axle[2].Y;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, 10}, {80, 10}}, color={0, 0, 127}),
        Ellipse(extent={{-90, 0}, {-30, -60}}, lineColor={0, 0, 127}),
        Ellipse(extent={{30, 0}, {90, -60}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Axes as in <a href=\"modelica://RailBraking.Components.GuidedWheelset\">GuidedWheelset</a>. Linear springs and dampers
at
the axle boxes, at the height of the axles. Angles are small.
</p>
<h4>Limitations</h4>
<p>The roll of the track is not differentiated: dampers act on the roll rate of the frame alone. No bump stops, no dry
friction.</p>
</html>"));
end GuidedFrame;
