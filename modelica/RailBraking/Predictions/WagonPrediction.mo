within RailBraking.Predictions;
block WagonPrediction "Wagon of two wheelsets as modelled by an estimator"
  extends Icons.Vehicle;
  parameter Types.Velocity start_speed(min=0) = 120/3.6 "Speed at the start";
  parameter Types.Ratio mu_b_start[2] = {0.35, 0.35} "Pad friction at the start";
  parameter Types.Ratio alpha_start = 0 "Adhesion at the start";
  parameter Types.Mass m = 40e3 "Mass of the wagon";
  parameter Types.Inertia J[2] = {130, 130} "Inertia of each wheelset about its axle";
  parameter Types.Length r_wheel = 0.46 "Rolling radius";
  parameter Types.Ratio n_units = 2 "Number of brake units of each wheelset";
  parameter Types.Length r_friction = 0.25 "Friction radius of the pads";
  parameter Types.Length h_mass = 1.5 "Height of the centre of mass over the rail";
  parameter Types.Length wheelbase = 9 "Distance of the wheelsets";
  parameter Types.Ratio c_drag = 0.9 "Drag coefficient";
  parameter Types.Area A_drag = 10 "Frontal area";
  parameter Types.Density rho_air = 1.2 "Density of the air";
  parameter Types.Ratio adhesion_share = 1
    "Braking force of the track over alpha m g: 1, or 1/2 as printed in (5) and (12)";
  parameter Types.Ratio resistance_transfer = -1
    "Load of the front wheelset over (track_force - drag) h_mass/wheelbase: -1, or 1 as printed";
  parameter Types.Ratio adhesion_transfer = 1
    "Load of the front wheelset over alpha m g h_mass/wheelbase: 1, or 0 as neglected in (12)";
  parameter Types.Ratio mu_b_relaxes(min=0, max=1) = 0 "1 for pad friction that relaxes towards mu_b_rest,
    0 for one without dynamics";
  parameter Types.Ratio mu_b_rest = 0.35 "Pad friction at rest, which relaxation approaches";
  parameter Types.Time T_mu = 30 "Time constant of relaxation, times pad friction";

  Interfaces.RealInput pad_force[2](each final unit="N", each start=0)
    "Normal force of both pads of one unit of each wheelset"
    annotation(Placement(transformation(extent={{-120, 57}, {-100, 77}})));
  Interfaces.RealInput track_force(final unit="N", start=0) "Force of gradient, curve and resistance, forward"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealInput wheel_torque[2](each final unit="N.m", each start=0)
    "Torque of motor and bearings on each wheelset, driving positive"
    annotation(Placement(transformation(extent={{-120, -77}, {-100, -57}})));
  Interfaces.RealOutput wheelset_speed[2](each final unit="rad/s") = w "Angular velocity of each wheelset"
    annotation(Placement(transformation(extent={{100, 40}, {120, 60}})));
  Interfaces.RealOutput speed(final unit="m/s") = v "Speed of the wagon"
    annotation(Placement(transformation(extent={{100, -60}, {120, -40}})));

  Types.AngularVelocity w[2](each start=start_speed/r_wheel, each fixed=true, each nominal=1,
    each stateSelect=StateSelect.always)
    "Angular velocity of each wheelset, front and rear";
  Types.Velocity v(start=start_speed, fixed=true, nominal=1, stateSelect=StateSelect.always) "Speed of the wagon";
  Types.Ratio mu_b[2](start=mu_b_start, each fixed=true, each nominal=0.1, each stateSelect=StateSelect.always)
    "Pad friction of each wheelset";
  Types.Ratio alpha(start=alpha_start, fixed=true, nominal=0.1, stateSelect=StateSelect.always)
    "Adhesion of both wheelsets, positive in braking";
protected
  Types.Force pull "Force along the track without adhesion";
  Types.Force transfer "Load that moves from the rear to the front wheelset";
  Types.Force load[2] "Load of each wheelset";
equation
  pull = track_force - rho_air/2*c_drag*A_drag*v^2;
  transfer = h_mass/wheelbase*(resistance_transfer*pull + adhesion_transfer*alpha*m*g);
  load = {m*g/2 + transfer, m*g/2 - transfer};
  for i in 1:2 loop
    J[i]*der(w[i]) = r_wheel*alpha*load[i] - n_units*mu_b[i]*r_friction*pad_force[i] + wheel_torque[i];
    der(mu_b[i]) = mu_b_relaxes*Friction.relaxation(mu_b[i], mu_b_rest, T_mu);
  end for;
  m*der(v) = pull - adhesion_share*alpha*m*g;
  der(alpha) = 0;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Six states: w, v, mu_b, alpha; equations (12) to (15) of Schwarz and Keck (2020), with signs changed so that forward
rotation, braking and adhesion
are positive. Free of events.
</p>
<h4>Implementation</h4>
<p>
Three terms differ from the paper; a parameter restores each printed form. Their equations (1), (2) and (4) give
a braking force of alpha m g; (5) and (12)
have half of it, which is right for one braked wheelset that carries m/2: <code>adhesion_share = 0.5</code>. With x
forward the front wheelset gains load when the wagon slows,
by -m der(v) h/a; (4) lets it lose that: <code>resistance_transfer = 1</code>. And (12) neglects the transfer by
adhesion, which is the larger part when braking:
<code>adhesion_transfer = 0</code>.
</p>
<h4>Limitations</h4>
<p>
Both wheelsets use the same adhesion. The wagon has no suspension: loads follow the acceleration at
once, and drag is assumed to act at the height of the rail.
</p>
</html>"));
end WagonPrediction;
