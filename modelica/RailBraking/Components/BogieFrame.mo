within RailBraking.Components;
model BogieFrame "Bogie frame on its primary suspension: bounce and pitch"
  extends Icons.Component;
  parameter Integer n(min=2) = 2 "Number of wheelsets" annotation(Evaluate=true);
  parameter Types.Mass m_wheelset[n](each start=14000) "Mass that each wheelset carries on the rail, including its own";
  parameter Types.Mass m_unsprung[n](each start=1500) "Mass of each wheelset alone";
  parameter Types.Mass m_frame(start=3500) "Mass of the frame";
  parameter Types.Inertia I_frame(start=2200) "Pitch inertia of the frame";
  parameter Types.Length h_frame(start=0.55) "Height of the frame's centre of gravity over the rail";
  parameter Types.Length h_rod(start=0.40) "Height of the traction rod over the rail";
  parameter Types.Length wheelbase(start=1.9) "Distance of the first and the last wheelset";
  parameter Types.Length r_wheel(start=0.38) "Height of the axles over the rail";
  parameter Types.Stiffness k(start=2.4e6) "Stiffness of the primary suspension over one wheelset";
  parameter Types.Damping c(start=2.4e4) "Damping of the primary suspension over one wheelset";
  Interfaces.RealInput a(final unit="m/s2") "Acceleration along the track"
    annotation(Placement(transformation(extent={{-120, 57}, {-100, 77}})));
  Interfaces.RealInput F(final unit="N") "Braking force of the track on all wheelsets together"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealInput torque(final unit="N.m") "Brake torque on all wheelsets together"
    annotation(Placement(transformation(extent={{-120, -77}, {-100, -57}})));
  Interfaces.RealInput rail_height[n](each final unit="m") "Height of each wheelset over its height on an even rail"
    annotation(Placement(transformation(extent={{-70, -120}, {-50, -100}}, rotation=90)));
  Interfaces.RealInput rail_rate[n](each final unit="m/s") "Upward speed of each wheelset"
    annotation(Placement(transformation(extent={{-10, -120}, {10, -100}}, rotation=90)));
  Interfaces.RealInput rail_acceleration[n](each final unit="m/s2") "Upward acceleration of each wheelset"
    annotation(Placement(transformation(extent={{50, -120}, {70, -100}}, rotation=90)));
  Interfaces.RealOutput load[n](each final unit="N") "Load of each wheelset on the rail"
    annotation(Placement(transformation(extent={{100, 65}, {120, 85}})));
  Interfaces.RealOutput work_power(final unit="W") "Power that the longitudinal forces put into the pitching frame"
    annotation(Placement(transformation(extent={{100, 15}, {120, 35}})));
  Interfaces.RealOutput damper_power(final unit="W") "Heat generated in the dampers"
    annotation(Placement(transformation(extent={{100, -35}, {120, -15}})));
  Interfaces.RealOutput stored_energy(final unit="J") "Energy of the frame's motion and of the springs"
    annotation(Placement(transformation(extent={{100, -85}, {120, -65}})));
  Types.Length bounce(nominal=1e-3) "Downward displacement of the frame, change from static";
  Types.Velocity bounce_rate(nominal=1e-2) "Its rate";
  Types.Angle pitch(nominal=1e-3) "Nose-down angle of the frame, change from static";
  Types.AngularVelocity pitch_rate(nominal=1e-2) "Its rate";
  Types.Length dz[n] "Deflection over each wheelset, change from static, compression positive";
  Types.Velocity ddz[n] "Rate of the deflection";
protected
  final parameter Types.Length arm[n] = {wheelbase/2 - (i - 1)*wheelbase/(n - 1) for i in 1:n}
    "Distance of each wheelset ahead of the frame's centre";
  Types.Force spring[n] "Spring and damper force over each wheelset, change from static";
  Types.Torque tipping "Torque that tips the frame nose-down, springs excluded";
equation
  der(bounce) = bounce_rate;
  der(pitch) = pitch_rate;
  dz = fill(bounce, n) + pitch*arm + rail_height;
  ddz = fill(bounce_rate, n) + pitch_rate*arm + rail_rate;
  spring = k*dz + c*ddz;
  tipping = frameTorque(F, torque, a, sum(m_unsprung), m_frame, h_frame, h_rod, r_wheel);
  m_frame*der(bounce_rate) = -sum(spring);
  I_frame*der(pitch_rate) = tipping - spring*arm;
  load = g*m_wheelset + spring + m_unsprung.*rail_acceleration;
  work_power = tipping*pitch_rate;
  damper_power = c*(ddz*ddz);
  stored_energy = m_frame*bounce_rate^2/2 + I_frame*pitch_rate^2/2 + k*(dz*dz)/2;
initial equation
  // The frame starts where it deflects the springs least, with the rates that the rail has there.
  bounce = -sum(rail_height)/n;
  bounce_rate = -sum(rail_rate)/n;
  pitch = -(rail_height*arm)/(arm*arm);
  pitch_rate = -(rail_rate*arm)/(arm*arm);
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
In braking, load moves from the rear to the front wheelset; at rest on level track it is &plusmn;&Sigma;F
h_rod/wheelbase for massless parts (see <a href=\"modelica://RailBraking.Validation.LoadTransfer\">LoadTransfer</a>
for the exact value).
</p>
<p>
The frame has two degrees of freedom, whatever the number of wheelsets; its bounce, its pitch and their rates are the
states. With h<sub>i</sub> the height of the rail under a wheelset x<sub>i</sub> ahead of the centre, the deflection is
dz<sub>i</sub> = bounce + x<sub>i</sub> pitch + h<sub>i</sub> and its force F<sub>i</sub> = k dz<sub>i</sub> + c
d(dz<sub>i</sub>)/dt: m_frame d&sup2;(bounce)/dt&sup2; = -&Sigma;F<sub>i</sub>, I_frame d&sup2;(pitch)/dt&sup2; =
tipping - &Sigma;F<sub>i</sub> x<sub>i</sub>. Deflections as states would drift with three wheelsets or more: no force
acts on the differences that the frame cannot follow.
</p>
<h4>Limitations</h4>
<p>
There are two wheelsets or more, with equal distances and symmetric about the frame's centre. The force of the car
body on the frame is constant, because air springs are soft in comparison with the primary suspension. Angles are small.
All masses move along the track at the speed of the train: the power that pitching takes from the
longitudinal motion, <code>work_power</code>, is not subtracted there. Its integral is exactly the
heat of the dampers plus <code>stored_energy</code>: of twenty megajoules, some ten joules in a
smooth stop, and 15 kJ in a stop in which slip control applies and releases the brakes all the time. Where the
rail is uneven, the dampers also take what it puts into the frame.
</p>
</html>"));
end BogieFrame;
