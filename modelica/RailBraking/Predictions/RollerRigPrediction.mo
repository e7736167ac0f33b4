within RailBraking.Predictions;
block RollerRigPrediction "Roller rig as modelled by an estimator"
  extends Icons.Vehicle;
  parameter Types.Velocity start_speed(min=0) = 120/3.6 "Speed at the start";
  parameter Types.Ratio mu_b_start = 0.35 "Pad friction at the start";
  parameter Types.Ratio alpha_start = 0 "Adhesion at the start";
  parameter Types.Mass m_imitated = 20e3 "Mass that roller and drive imitate together";
  parameter Types.Force load = 98.1e3 "Load of the wheelset on the roller";
  parameter Types.Inertia J = 130 "Inertia of the wheelset with its discs about its axle";
  parameter Types.Length r_wheel = 0.46 "Rolling radius of the wheelset";
  parameter Types.Ratio n_units = 2 "Number of brake units";
  parameter Types.Length r_friction = 0.25 "Friction radius of the pads";
  parameter Types.Ratio mu_bearing = 0.0018 "Friction coefficient of the axle bearings";
  parameter Types.Length r_bearing = 0.065 "Radius of the axle bearings";
  parameter Types.Length e_rolling = 0.0004 "Lever arm of the rolling resistance";
  parameter Types.Ratio c_drag = 0.9 "Drag coefficient that the drive imitates";
  parameter Types.Area A_drag = 5 "Frontal area that the drive imitates";
  parameter Types.Density rho_air = 1.2 "Density of the air";
  parameter Types.Ratio mu_b_relaxes(min=0, max=1) = 0 "1 for pad friction that relaxes towards mu_b_rest,
    0 for one without dynamics";
  parameter Types.Ratio mu_b_rest = 0.35 "Pad friction at rest, which relaxation approaches";
  parameter Types.Time T_mu = 30 "Time constant of relaxation, times pad friction";

  Interfaces.RealInput pad_force(final unit="N", start=0) "Normal force of both pads of one unit"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealOutput wheelset_speed(final unit="rad/s") = w "Angular velocity of the wheelset"
    annotation(Placement(transformation(extent={{100, 40}, {120, 60}})));
  Interfaces.RealOutput speed(final unit="m/s") = v "Speed of the roller's surface"
    annotation(Placement(transformation(extent={{100, -60}, {120, -40}})));

  Types.AngularVelocity w(start=start_speed/r_wheel, fixed=true, nominal=1, stateSelect=StateSelect.always)
    "Angular velocity";
  Types.Velocity v(start=start_speed, fixed=true, nominal=1, stateSelect=StateSelect.always)
    "Speed of the roller's surface";
  Types.Ratio mu_b(start=mu_b_start, fixed=true, nominal=0.1, stateSelect=StateSelect.always) "Pad friction";
  Types.Ratio alpha(start=alpha_start, fixed=true, nominal=0.1, stateSelect=StateSelect.always)
    "Adhesion, positive in braking";
protected
  final parameter Types.Ratio f_resistance = Components.bearingFriction(mu_bearing, r_bearing,
    r_wheel) + e_rolling/r_wheel
    "Bearing and rolling resistance at the rim over load";
equation
  J*der(w) = r_wheel*load*(alpha - f_resistance) - n_units*mu_b*r_friction*pad_force;
  m_imitated*der(v) = -alpha*load - rho_air/2*c_drag*A_drag*v^2;
  der(mu_b) = mu_b_relaxes*Friction.relaxation(mu_b, mu_b_rest, T_mu);
  der(alpha) = 0;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Four states: w, v, mu_b, alpha; equation (19) of Schwarz and Keck (2020), with reversed signs, so
that braking is positive. Free of events.
Pad friction is that of their equation (8), without dynamics, or of (9) with <code>mu_b_relaxes = 1</code>.
</p>
<h4>Limitations</h4>
<p>
Load, mass and drag are assumed to be known: the filter attributes the relative error of a load cell
to adhesion. With the pads released their friction is unobservable and must be frozen.
</p>
</html>"));
end RollerRigPrediction;
