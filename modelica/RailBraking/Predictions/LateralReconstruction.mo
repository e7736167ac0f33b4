within RailBraking.Predictions;
block LateralReconstruction "Lateral dynamics with creep, friction and creep force among five states, a reconstruction"
  extends Icons.Vehicle;
  extends Vehicles.PartialLateralWheelset;
  parameter Types.Ratio friction_start = 0.46 "Friction coefficient at the start";
  Interfaces.RealInput lateral_position(final unit="m", start=0) "Integral of the lateral velocity"
    annotation(Placement(transformation(extent={{-120, 78}, {-100, 98}})));
  Interfaces.RealInput yaw_angle(final unit="rad", start=0) "Integral of the yaw rate"
    annotation(Placement(transformation(extent={{-120, 52}, {-100, 72}})));
  Interfaces.RealInput track(final unit="m", start=0) "Lateral position of the middle of the track"
    annotation(Placement(transformation(extent={{-120, 28}, {-100, 48}})));
  Interfaces.RealInput track_rate(final unit="m/s", start=0) "Derivative of track"
    annotation(Placement(transformation(extent={{-120, 2}, {-100, 22}})));
  Interfaces.RealInput speed(final unit="m/s", start=25) "Speed along the track"
    annotation(Placement(transformation(extent={{-120, -22}, {-100, -2}})));
  Interfaces.RealInput mu0(final unit="1", start=0.46) "Maximum friction coefficient, known"
    annotation(Placement(transformation(extent={{-120, -48}, {-100, -28}})));
  Interfaces.RealInput A_falling(final unit="1", start=0.4)
    "Polach: friction at infinite creep speed over maximum friction"
    annotation(Placement(transformation(extent={{-120, -72}, {-100, -52}})));
  Interfaces.RealInput B_falling(final unit="s/m", start=0.6) "Polach: rate at which friction falls with creep speed"
    annotation(Placement(transformation(extent={{-120, -98}, {-100, -78}})));
  Interfaces.RealOutput lateral_acceleration(final unit="m/s2") = der(dy) "Reading of the accelerometer"
    annotation(Placement(transformation(extent={{100, 40}, {120, 60}})));
  Interfaces.RealOutput yaw_rate(final unit="rad/s") = dpsi "Reading of the gyroscope"
    annotation(Placement(transformation(extent={{100, -60}, {120, -40}})));
  Types.Velocity dy(start=0, fixed=true, nominal=1e-2, stateSelect=StateSelect.always) "Lateral velocity";
  Types.AngularVelocity dpsi(start=0, fixed=true, nominal=1e-2, stateSelect=StateSelect.always) "Yaw rate";
  Types.Ratio gamma(start=creep_small, fixed=true, nominal=1e-3, stateSelect=StateSelect.always)
    "Total creep of each wheel";
  Types.Ratio U(start=friction_start, fixed=true, nominal=0.1, stateSelect=StateSelect.always)
    "Friction coefficient at the present creep";
  Types.Force F(start=0, fixed=true, nominal=1e3, stateSelect=StateSelect.always) "Total creep force of each wheel";
protected
  Types.Ratio creep_x "Longitudinal creep of the right wheel";
  Types.Ratio creep_y "Lateral creep of both wheels";
  Real over_creep(final unit="1") "Reciprocal of the total creep, rounded to stay finite";
  Types.AngularAcceleration yaw_acceleration "Yaw acceleration";
  Real creep_x_rate(final unit="1/s") "Derivative of creep_x";
  Real creep_y_rate(final unit="1/s") "Derivative of creep_y";
  Real creep_rate(final unit="1/s") "Derivative of the total creep";
  Real friction_rate(final unit="1/s") "Derivative of the friction coefficient";
  Types.Force F_by_creep "Slope of the creep force over the creep";
  Types.Force F_by_friction "Slope of the creep force over the friction coefficient";
equation
  creep_x = half_gauge*dpsi/speed + conicity*(lateral_position - track)/r_wheel;
  creep_y = dy/speed - yaw_angle;
  over_creep = gamma/(gamma^2 + creep_small^2);
  m_unsprung*der(dy) = -2*F*over_creep*creep_y;
  yaw_acceleration = -2*half_gauge*F*over_creep*creep_x/I_yaw - k_yaw/I_yaw*yaw_angle;
  der(dpsi) = yaw_acceleration;
  creep_x_rate = half_gauge*yaw_acceleration/speed + conicity*(dy - track_rate)/r_wheel;
  creep_y_rate = lateral_acceleration/speed - dpsi;
  creep_rate = (creep_x*creep_x_rate + creep_y*creep_y_rate)*over_creep;
  friction_rate = -B_falling*speed*(U - A_falling*mu0)*creep_rate;
  (F_by_creep, F_by_friction) = Contact.polachSlopes(gamma, U, Q, factor, k_A, k_S);
  der(gamma) = creep_rate;
  der(U) = friction_rate;
  der(F) = F_by_creep*creep_rate + F_by_friction*friction_rate;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
A reconstruction of the filter model of Mal et al. (2020). The text of the paper that was available names the five
states, the measured quantities and the numbers of the equations, but does not contain the bodies of equations (18) to
(36). The equations here are derived from the words: equal creep of both wheels, the equations of motion of <a
href=\"modelica://RailBraking.Plants.LateralWheelset\">LateralWheelset</a>, and the derivatives with respect to time of
total creep, friction coefficient and Polach's force. The authors' equations may differ.
</p>
<p>
Lateral position and yaw angle are needed, but are not among the five states: the program that runs this model
integrates the two velocities and returns the integrals as inputs.
</p>
<h4>Limitations</h4>
<p>
Creep, friction and force are related only through their derivatives: an error in one of them, or a change of the
surface, remains until a reading corrects it. The derivative of the creep is singular at zero creep; the rounding
<code>creep_small</code> keeps it finite but not correct. Without traction and braking.
</p>
</html>"));
end LateralReconstruction;
