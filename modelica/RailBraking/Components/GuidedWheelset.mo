within RailBraking.Components;
model GuidedWheelset "Wheelset with longitudinal, lateral, vertical, yaw and rolling motion on elastic track"
  extends Icons.Component;
  parameter Types.Mass m(start=1400) "Mass";
  parameter Types.Inertia I_yaw(start=800) "Inertia about the vertical axis";
  parameter Types.Inertia J(start=110) "Inertia about the axle";
  parameter Types.Length r(start=0.42) "Rolling radius in the middle of the track";
  parameter Types.Length r_rail = 0.30 "Radius of the rail head across the track";
  parameter Types.Modulus E = 2.1e11 "Young's modulus of wheel and rail";
  parameter Types.Ratio nu = 0.28 "Poisson's ratio of wheel and rail";
  parameter Types.Ratio kalker_ratio = 0.89 "Kalker's c22 over c11";
  parameter Types.Length b = 0.75 "Half the distance of the contacts";
  parameter Types.Ratio conicity(start=0.15) "Equivalent conicity";
  parameter Types.Stiffness k_track = 5e7 "Stiffness of the track under one wheel";
  parameter Types.Damping c_track = 6e4 "Damping of the track under one wheel";
  parameter Types.Length clearance = 6e-3 "Clearance of the flange on either side";
  parameter Types.Stiffness k_flange = 1e7 "Stiffness of the flange against the rail";
  parameter Types.Force load_nominal(start=1.2e5) "Load of both wheels at rest";
  parameter Types.Ratio k_A(start=0.3) "Polach: reduction of the creep stiffness in the area of adhesion";
  parameter Types.Ratio k_S(start=0.1) "Polach: reduction of the creep stiffness in the area of slip";
  parameter Types.Ratio A(start=0.4) "Polach: friction at infinite slip speed over maximum friction";
  parameter Types.InverseVelocity B(start=0.2) "Polach: rate at which friction falls with slip speed";
  parameter Types.Velocity start_speed(start=20) "Speed at the start";
  final parameter Real factor = Contact.creepFactor(r, r_rail, E, nu) "Slope of epsilon, see creepFactor";
  Interfaces.GuidedFlange frame "To the axle boxes of a frame, whose drive turns the axle; may be left open"
    annotation(Placement(transformation(extent={{-10, 100}, {10, 120}})));
  Interfaces.RealInput alignment(final unit="m") "Lateral irregularity, to the left"
    annotation(Placement(transformation(extent={{-118, -26}, {-102, -10}})));
  Interfaces.RealInput vertical(final unit="m") "Vertical irregularity, upwards"
    annotation(Placement(transformation(extent={{-118, -44}, {-102, -28}})));
  Interfaces.RealInput cross_level(final unit="m") "Left rail above right rail"
    annotation(Placement(transformation(extent={{-118, -63}, {-102, -47}})));
  Interfaces.RealInput gauge(final unit="m") "Widening of the gauge"
    annotation(Placement(transformation(extent={{-118, -81}, {-102, -65}})));
  Interfaces.RealInput mu0(final unit="1") "Maximum friction coefficient"
    annotation(Placement(transformation(extent={{-118, -99}, {-102, -83}})));
  Types.Length x(start=0, fixed=true, nominal=1e-2) "Position along the track relative to an even run at start_speed";
  Types.Velocity dv(start=0, fixed=true, nominal=1e-2) "Speed along the track, change from start_speed";
  Types.Length y(start=0, fixed=true, nominal=1e-3) "Lateral position, to the left";
  Types.Velocity vy(start=0, fixed=true, nominal=1e-2) "Lateral speed";
  Real psi(final unit="rad", start=0, fixed=true, nominal=1e-3) "Yaw angle, to the left";
  Types.AngularVelocity wz(start=0, fixed=true, nominal=1e-2) "Yaw rate";
  Types.Length z(start=0, fixed=true, nominal=1e-3) "Height, change from static";
  Types.Velocity vz(start=0, fixed=true, nominal=1e-2) "Vertical speed";
  Types.AngularVelocity dw(start=0, fixed=true, nominal=1e-2) "Angular velocity about the axle minus start_speed/r";
  Types.Acceleration a "Acceleration along the track";
  Types.Acceleration ay "Acceleration across the track";
  Types.Acceleration az "Upward acceleration";
  Types.AngularAcceleration a_yaw "Yaw acceleration";
  Types.Ratio creep_x[2] "Creepage along the track, left and right";
  Types.Velocity v "Speed along the track";
  Types.AngularVelocity w "Angular velocity about the axle";
  Types.Ratio creep_y "Creepage across the track";
  Types.Length offset "Lateral position on the track";
protected
  Types.Force Q[2] "Load of the left and of the right wheel";
  Types.Force load "Load of both wheels";
  constant Types.Length rounding = 5e-4 "Displacement over which a flange comes into contact";
  Types.Length pressed[2] "Penetration of the left and of the right flange into its rail";
  Types.Ratio chord[2] "Adhesion over creepage, left and right";
  Types.Force F_x[2] "Force on the left and on the right wheel, forward";
  Types.Force F_y "Force on both wheels, to the left";
  Types.Length r_rolling[2] "Rolling radius of the left and of the right wheel";
equation
  frame.x = x;
  frame.y = y;
  frame.z = z;
  frame.phi = cross_level/(2*b);
  frame.theta = 0;
  frame.psi = psi;
  v = start_speed + dv;
  w = start_speed/r + dw;
  offset = y - alignment;
  pressed = {
    (offset - clearance + sqrt((offset - clearance)^2 + rounding^2))/2,
    (-offset - clearance + sqrt((offset + clearance)^2 + rounding^2))/2};
  r_rolling = {r + conicity*(offset - gauge/2), r - conicity*(offset + gauge/2)};
  creep_x = {(v - b*wz - r_rolling[1]*w)/v, (v + b*wz - r_rolling[2]*w)/v};
  creep_y = vy/v - psi;
  load = load_nominal + 2*k_track*(vertical - z) - 2*c_track*vz;
  Q = {load/2 + (r*frame.Y - frame.M_phi)/(2*b), load/2 - (r*frame.Y - frame.M_phi)/(2*b)};
  for i in 1:2 loop
    chord[i] = Contact.combinedChord(creep_x[i], creep_y, v, Q[i], mu0, factor, kalker_ratio, k_A, k_S, A, B);
    F_x[i] = -chord[i]*Q[i]*creep_x[i];
  end for;
  F_y = -(chord[1]*Q[1] + chord[2]*Q[2])*creep_y;
  der(x) = dv;
  der(dv) = a;
  m*a = frame.X + F_x[1] + F_x[2];
  der(y) = vy;
  der(vy) = ay;
  m*ay = frame.Y + F_y - k_flange*(pressed[1] - pressed[2]) - load*cross_level/(2*b);
  der(psi) = wz;
  der(wz) = a_yaw;
  I_yaw*a_yaw = frame.M_psi + b*(F_x[2] - F_x[1]);
  der(z) = vz;
  der(vz) = az;
  m*az = load - load_nominal + frame.Z;
  J*der(dw) = frame.M_theta - r_rolling[1]*F_x[1] - r_rolling[2]*F_x[2];
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-70, 0}, {70, 0}}, color={0, 0, 127}),
        Rectangle(extent={{-60, 60}, {-40, -60}}, lineColor={0, 0, 127}),
        Rectangle(extent={{40, 60}, {60, -60}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Axes: x along the track, y to the left, z upwards; angles follow the right-hand rule. The wheels are cones: the
rolling radii
differ by 2 conicity times the lateral position on the track, and widening of the gauge makes both smaller. The rail
pushes
the wheelset to the side of the lower rail with load times cross level over 2 b.
</p>
<h4>Limitations</h4>
<p>
The flange is a spring without friction that acts beyond the clearance; before that its rounding
acts like a spring of 0.03 MN/m. The wheelset follows the track in roll. The
damping of the track acts on the vertical speed of the wheelset, not on that of the irregularity; the wheelset bounces
on the track at about 42 Hz. Loads must stay positive. Forward running only.
</p>
</html>"));
end GuidedWheelset;
