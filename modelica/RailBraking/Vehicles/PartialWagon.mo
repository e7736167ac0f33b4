within RailBraking.Vehicles;
partial block PartialWagon "Wagon of two braked wheelsets, without the supply of the cylinders"
  extends Icons.Vehicle;
  parameter Types.Velocity start_speed(min=0) = 120/3.6 "Speed at the start"
    annotation(Dialog(group="Start"));
  parameter Types.Ratio wheelsets_per_group[2] = {1, 1}
    "Number of wheelsets that turn as one, leading group first; a description that cannot be changed"
    annotation(Dialog(group="Formation"));
  parameter Types.Ratio wheelsets_per_car[1] = {2}
    "Number of wheelsets of each car; a description that cannot be changed" annotation(Dialog(group="Formation"));
  parameter Types.Length wheelset_position[2] = {0, 9}
    "Distance of each wheelset behind the leading one; a description that cannot be changed"
    annotation(Dialog(group="Formation"));
  parameter Types.Mass m = 40e3 "Mass of the wagon" annotation(Dialog(group="Wagon"));
  parameter Types.Inertia J[2] = {130, 130} "Inertia of each wheelset about its axle" annotation(Dialog(group="Wagon"));
  parameter Types.Length r_wheel[2] = {0.46, 0.46} "Rolling radius of each wheelset" annotation(Dialog(group="Wagon"));
  parameter Types.Length h_mass = 1.5 "Height of the centre of mass over the rail" annotation(Dialog(group="Wagon"));
  parameter Types.Length wheelbase = 9 "Distance of the wheelsets" annotation(Dialog(group="Wagon"));
  parameter Types.Time T_pitch = 0.2 "Time constant with which the suspension transmits a change of load"
    annotation(Dialog(group="Wagon"));
  parameter Types.Ratio n_units = 2 "Number of brake units of each wheelset" annotation(Dialog(group="Brake"));
  parameter Types.Length r_friction = 0.25 "Friction radius of the pads" annotation(Dialog(group="Brake"));
  parameter Types.Pressure p_max = 3.0e5 "Maximum cylinder pressure" annotation(Dialog(group="Brake"));
  parameter Types.Area A_piston = 0.0324 "Area of a piston" annotation(Dialog(group="Brake"));
  parameter Types.Ratio i_rigging = 6 "Force of both pads over force of the piston" annotation(Dialog(group="Brake"));
  parameter Types.Ratio eta_rigging = 0.95 "Efficiency of the rigging" annotation(Dialog(group="Brake"));
  parameter Types.Force F_spring = 1200 "Force of return spring and slack adjuster" annotation(Dialog(group="Brake"));
  parameter Types.Volume V_cylinder = 3e-3 "Volume of cylinder and hose of one unit" annotation(Dialog(group="Brake"));
  parameter Types.Ratio mu_b_nominal[2] = {0.35, 0.35} "Pad friction at nominal speed, pressure and temperature"
    annotation(Dialog(group="Pads"));
  parameter Types.Ratio mu_b_start[2] = {0.35, 0.35} "Pad friction at the start" annotation(Dialog(group="Start"));
  parameter Types.Ratio speed_effect = 0.12 "Rise of pad friction from nominal speed to standstill, relative"
    annotation(Dialog(group="Pads"));
  parameter Types.Velocity pad_speed_nominal = 13 "Sliding speed at which pad friction is nominal"
    annotation(Dialog(group="Pads"));
  parameter Types.Ratio temperature_effect = 0.10 "Rise of pad friction over the temperature range, relative"
    annotation(Dialog(group="Pads"));
  parameter Types.Ratio force_effect = 0.08 "Loss of pad friction at twice the nominal pad force, relative"
    annotation(Dialog(group="Pads"));
  parameter Types.Force pad_force_nominal = 56e3 "Pad force at which pad friction is nominal"
    annotation(Dialog(group="Pads"));
  parameter Types.Energy E_settle = 2e5 "Friction energy of one unit within which pad friction settles"
    annotation(Dialog(group="Pads"));
  parameter Types.Time T_settle = 3 "Time within which pad friction settles at low power"
    annotation(Dialog(group="Pads"));
  parameter Types.Temperature T_disc_start = 313.15 "Temperature of the discs at the start"
    annotation(Dialog(group="Start"));
  parameter Types.Ratio k_A = 0.3 "Polach: reduction of the creep stiffness in the area of adhesion"
    annotation(Dialog(group="Contact"));
  parameter Types.Ratio k_S = 0.1 "Polach: reduction of the creep stiffness in the area of slip"
    annotation(Dialog(group="Contact"));
  parameter Types.Ratio A_falling = 0.4 "Polach: friction at infinite slip speed over maximum friction"
    annotation(Dialog(group="Contact"));
  parameter Types.InverseVelocity B_falling = 0.2 "Polach: rate at which friction falls with slip speed"
    annotation(Dialog(group="Contact"));
  parameter Types.Length r_rail = 0.30 "Radius of the rail head across the track" annotation(Dialog(group="Contact"));
  parameter Types.Modulus E_steel = 2.1e11 "Young's modulus of wheel and rail" annotation(Dialog(group="Contact"));
  parameter Types.Ratio nu_steel = 0.28 "Poisson's ratio of wheel and rail" annotation(Dialog(group="Contact"));
  parameter Types.Velocity v_small = 0.1 "Speed below which slip is regularised" annotation(Dialog(group="Contact"));
  parameter Types.Ratio mu_bearing = 0.0018 "Friction coefficient of the axle bearings"
    annotation(Dialog(group="Resistance"));
  parameter Types.Length r_bearing = 0.065 "Radius of the axle bearings" annotation(Dialog(group="Resistance"));
  parameter Types.Length e_rolling = 0.0004 "Lever arm of the rolling resistance"
    annotation(Dialog(group="Resistance"));
  parameter Types.Ratio c_drag = 0.9 "Drag coefficient" annotation(Dialog(group="Resistance"));
  parameter Types.Area A_drag = 10 "Frontal area" annotation(Dialog(group="Resistance"));
  parameter Types.Density rho_air = 1.2 "Density of the air" annotation(Dialog(group="Resistance"));

  Interfaces.RealInput mu0[2](each final unit="1", each start=0)
    "Maximum friction coefficient of the rail at each wheelset"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput track_force(final unit="N", start=0) "Force of gradient and curve, forward"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));

  Interfaces.RealOutput distance(final unit="m") "Distance travelled"
    annotation(Placement(transformation(extent={{104, 87}, {116, 99}})));
  Interfaces.RealOutput speed(final unit="m/s") "Speed of the wagon"
    annotation(Placement(transformation(extent={{104, 73}, {116, 85}})));
  Interfaces.RealOutput acceleration(final unit="m/s2") "Acceleration of the wagon"
    annotation(Placement(transformation(extent={{104, 58}, {116, 70}})));
  Interfaces.RealOutput wheelset_speed[2](each final unit="rad/s") "Angular velocity of each wheelset"
    annotation(Placement(transformation(extent={{104, 44}, {116, 56}})));
  Interfaces.RealOutput slip[2](each final unit="1") "Slip of each wheelset, 0 rolling, 1 locked"
    annotation(Placement(transformation(extent={{104, 30}, {116, 42}})));
  Interfaces.RealOutput adhesion[2](each final unit="1") "Adhesion used by each wheelset, positive in braking"
    annotation(Placement(transformation(extent={{104, 15}, {116, 27}})));
  Interfaces.RealOutput wheelset_load[2](each final unit="N") "Load of each wheelset on the rail"
    annotation(Placement(transformation(extent={{104, 1}, {116, 13}})));
  Interfaces.RealOutput cylinder_pressure[2](each final unit="Pa") "Pressure in the cylinders of each wheelset"
    annotation(Placement(transformation(extent={{104, -13}, {116, -1}})));
  Interfaces.RealOutput pad_force[2](each final unit="N") "Normal force of both pads of one unit of each wheelset"
    annotation(Placement(transformation(extent={{104, -27}, {116, -15}})));
  Interfaces.RealOutput pad_friction[2](each final unit="1") "Friction coefficient of the pads"
    annotation(Placement(transformation(extent={{104, -42}, {116, -30}})));
  Interfaces.RealOutput disc_temperature[2](each final unit="K") "Temperature of the bulk of the discs"
    annotation(Placement(transformation(extent={{104, -56}, {116, -44}})));
  Interfaces.RealOutput resistance_torque[2](each final unit="N.m")
    "Torque of bearing and rolling resistance on each wheelset"
    annotation(Placement(transformation(extent={{104, -70}, {116, -58}})));
  Interfaces.BooleanOutput locked[2] "= true, if the wheelset is locked"
    annotation(Placement(transformation(extent={{104, -85}, {116, -73}})));
  Interfaces.BooleanOutput standstill "= true, if the wagon is at rest"
    annotation(Placement(transformation(extent={{104, -99}, {116, -87}})));
  replaceable block TrainContact = Contact.WheelsetContact constrainedby Interfaces.PartialContact
    "Law of the contacts";
  replaceable block TrainShaft = Components.RigidShaft constrainedby Interfaces.PartialShaft
    "Shafts between wheels and brake discs";
protected
  final parameter Data.Creep creep = Data.Creep(
    k_A=k_A, k_S=k_S, A=A_falling, B=B_falling, r_rail=r_rail, E=E_steel, nu=nu_steel, v_small=v_small) "Contact";
  Data.CreepCurve curve[2] = {Data.CreepCurve(k_A=k_A, k_S=k_S, A=A_falling, B=B_falling) for i in 1:2}
    "Shape of the creep curve at each wheelset";
  final parameter Data.Resistance resistance = Data.Resistance(
    mu_bearing=mu_bearing, r_bearing=r_bearing, e_rolling=e_rolling) "Bearings and rolling";
  final parameter Data.Pad pads = Data.Pad(
    speed_effect=speed_effect, pad_speed_nominal=pad_speed_nominal, temperature_effect=temperature_effect,
    force_effect=force_effect, pad_force_nominal=pad_force_nominal, E_settle=E_settle, T_settle=T_settle) "Pads";
  final parameter Data.Drag drag = Data.Drag(c_drag=c_drag, A_drag=A_drag, rho_air=rho_air) "Air";
  Components.CarBody body(m=m, start_speed=start_speed, drag=drag) "Wagon"
    annotation(Placement(transformation(extent={{-20, 40}, {20, 80}})));
  Components.Rest rest(final n=1) "Detection of standstill"
    annotation(Placement(transformation(extent={{-80, 40}, {-40, 80}})));
  Components.Axle front(
    redeclare block AxleContact = TrainContact, redeclare block AxleShaft = TrainShaft,
    final n=1, J=J[1], r_wheel=r_wheel[1], n_units=n_units, r_friction=r_friction, mu_b_nominal=mu_b_nominal[1],
    mu_b_start=mu_b_start[1], T_disc_start=T_disc_start, start_speed=start_speed, creep=creep, curve=curve[1:1],
    resistance=resistance, pads=pads) "Front wheelset"
    annotation(Placement(transformation(extent={{-80, -20}, {-40, 20}})));
  Components.Axle rear(
    redeclare block AxleContact = TrainContact, redeclare block AxleShaft = TrainShaft,
    final n=1, J=J[2], r_wheel=r_wheel[2], n_units=n_units, r_friction=r_friction, mu_b_nominal=mu_b_nominal[2],
    mu_b_start=mu_b_start[2], T_disc_start=T_disc_start, start_speed=start_speed, creep=creep, curve=curve[2:2],
    resistance=resistance, pads=pads) "Rear wheelset"
    annotation(Placement(transformation(extent={{40, -20}, {80, 20}})));
  Types.Length s(start=0, fixed=true, nominal=1) "Distance travelled";
  Types.Force transfer(start=0, fixed=true, nominal=1e4) "Load that has moved from the rear to the front wheelset";
equation
  T_pitch*der(transfer) = -h_mass/wheelbase*m*acceleration - transfer;
  wheelset_load = {m*g/2 + transfer, m*g/2 - transfer};
  connect(front.box, body.pivot)
    annotation(Line(points={{-60, 22}, {-60, 30}, {0, 30}, {0, 38}}, color={0, 0, 127}));
  connect(rear.box, body.pivot)
    annotation(Line(points={{60, 22}, {60, 30}, {0, 30}, {0, 38}}, color={0, 0, 127}));
  front.load = {wheelset_load[1]};
  front.mu0 = {mu0[1]};
  front.pad_force = pad_force[1];
  front.standstill = standstill;
  rear.load = {wheelset_load[2]};
  rear.mu0 = {mu0[2]};
  rear.pad_force = pad_force[2];
  rear.standstill = standstill;
  wheelset_speed = {front.group.w, rear.group.w};
  slip = {front.group.slip, rear.group.slip};
  adhesion = {front.group.adhesion, rear.group.adhesion};
  pad_friction = {front.group.pad_friction, rear.group.pad_friction};
  disc_temperature = {front.group.disc_temperature, rear.group.disc_temperature};
  resistance_torque = {
    (r_wheel[1]*front.wheels.f_bearing + e_rolling)*wheelset_load[1],
    (r_wheel[2]*rear.wheels.f_bearing + e_rolling)*wheelset_load[2]};
  locked = {front.group.locked, rear.group.locked};
  body.track_force = track_force;
  body.standstill = standstill;
  rest.v = {body.v};
  rest.track_force = track_force;
  rest.capacity = front.totals.capacity + rear.totals.capacity;
  der(s) = speed;
  distance = s;
  speed = body.v;
  acceleration = body.a;
  standstill = rest.standstill;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-90, 20}, {90, -40}}, lineColor={0, 0, 127}),
        Ellipse(extent={{-78, -52}, {-42, -88}}, lineColor={0, 0, 127}),
        Ellipse(extent={{42, -52}, {78, -88}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The generic wagon of Schwarz and Keck (2020, figure 1): two <a
href=\"modelica://RailBraking.Components.Axle\">Axles</a> under one <a
href=\"modelica://RailBraking.Components.CarBody\">CarBody</a>, without bogies. In braking the front wheelset gains -m
der(v) h_mass/wheelbase, with the lag <code>T_pitch</code> of a suspension.
</p>
<h4>Limitations</h4>
<p>
Pitching of the wagon body is represented by the change of loads only; drag acts at the height of the rail. Forward
motion only.
</p>
</html>"));
end PartialWagon;
