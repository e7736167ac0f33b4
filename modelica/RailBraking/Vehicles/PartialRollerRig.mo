within RailBraking.Vehicles;
partial block PartialRollerRig "Braked wheelset on a roller that imitates a wagon, without the supply of the cylinders"
  extends Icons.Vehicle;
  parameter Types.Velocity start_speed(min=0) = 120/3.6 "Speed of the roller's surface at the start"
    annotation(Dialog(group="Start"));
  parameter Types.Mass m_imitated = 20e3 "Mass that roller and drive imitate together" annotation(Dialog(group="Rig"));
  parameter Types.Force load = 98.1e3 "Mean load of the wheelset on the roller" annotation(Dialog(group="Rig"));
  parameter Types.Ratio load_ripple(min=0, max=0.2) = 0.01
    "Amplitude of the load once each turn of the roller, relative" annotation(Dialog(group="Rig"));
  parameter Types.Length r_roller = 1.0 "Radius of the roller" annotation(Dialog(group="Rig"));
  parameter Types.Inertia J_roller = 6e3 "Inertia of the roller itself" annotation(Dialog(group="Rig"));
  parameter Types.Inertia J = 130 "Inertia of the wheelset with its discs about its axle"
    annotation(Dialog(group="Rig"));
  parameter Types.Length r_wheel = 0.46 "Rolling radius of the wheelset" annotation(Dialog(group="Rig"));
  parameter Types.Ratio n_units = 2 "Number of brake units of the wheelset" annotation(Dialog(group="Brake"));
  parameter Types.Length r_friction = 0.25 "Friction radius of the pads" annotation(Dialog(group="Brake"));
  parameter Types.Pressure p_max = 3.0e5 "Maximum cylinder pressure" annotation(Dialog(group="Brake"));
  parameter Types.Area A_piston = 0.0324 "Area of a piston" annotation(Dialog(group="Brake"));
  parameter Types.Ratio i_rigging = 6 "Force of both pads over force of the piston" annotation(Dialog(group="Brake"));
  parameter Types.Ratio eta_rigging = 0.95 "Efficiency of the rigging" annotation(Dialog(group="Brake"));
  parameter Types.Force F_spring = 1200 "Force of return spring and slack adjuster" annotation(Dialog(group="Brake"));
  parameter Types.Volume V_cylinder = 3e-3 "Volume of cylinder and hose of one unit" annotation(Dialog(group="Brake"));
  parameter Types.Ratio mu_b_nominal = 0.35 "Pad friction at nominal speed, pressure and temperature"
    annotation(Dialog(group="Pads"));
  parameter Types.Ratio mu_b_start = 0.35 "Pad friction at the start" annotation(Dialog(group="Start"));
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
  parameter Types.Length r_rail = 0.30 "Radius of the rail head, here of the roller, across the track"
    annotation(Dialog(group="Contact"));
  parameter Types.Modulus E_steel = 2.1e11 "Young's modulus of wheel and rail" annotation(Dialog(group="Contact"));
  parameter Types.Ratio nu_steel = 0.28 "Poisson's ratio of wheel and rail" annotation(Dialog(group="Contact"));
  parameter Types.Velocity v_small = 0.1 "Speed below which slip is regularised" annotation(Dialog(group="Contact"));
  parameter Types.Ratio mu_bearing = 0.0018 "Friction coefficient of the axle bearings"
    annotation(Dialog(group="Resistance"));
  parameter Types.Length r_bearing = 0.065 "Radius of the axle bearings" annotation(Dialog(group="Resistance"));
  parameter Types.Length e_rolling = 0.0004 "Lever arm of the rolling resistance"
    annotation(Dialog(group="Resistance"));
  parameter Types.Ratio c_drag = 0.9 "Drag coefficient that the drive imitates" annotation(Dialog(group="Resistance"));
  parameter Types.Area A_drag = 5 "Frontal area that the drive imitates" annotation(Dialog(group="Resistance"));
  parameter Types.Density rho_air = 1.2 "Density of the air" annotation(Dialog(group="Resistance"));

  Interfaces.RealInput mu0(final unit="1", start=0) "Maximum friction coefficient between wheel and roller"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));

  Interfaces.RealOutput distance(final unit="m") "Distance that the wagon would have travelled"
    annotation(Placement(transformation(extent={{105, 89}, {115, 99}})));
  Interfaces.RealOutput speed(final unit="m/s") "Speed of the roller's surface: of the wagon"
    annotation(Placement(transformation(extent={{105, 76}, {115, 86}})));
  Interfaces.RealOutput acceleration(final unit="m/s2") "Acceleration of the roller's surface"
    annotation(Placement(transformation(extent={{105, 64}, {115, 74}})));
  Interfaces.RealOutput wheelset_speed(final unit="rad/s") "Angular velocity of the wheelset"
    annotation(Placement(transformation(extent={{105, 51}, {115, 61}})));
  Interfaces.RealOutput slip(final unit="1") "Slip, 0 rolling, 1 locked"
    annotation(Placement(transformation(extent={{105, 39}, {115, 49}})));
  Interfaces.RealOutput adhesion(final unit="1") "Adhesion used, positive in braking"
    annotation(Placement(transformation(extent={{105, 26}, {115, 36}})));
  Interfaces.RealOutput contact_force(final unit="N")
    "Force of the roller on the wheelset along the track, positive in braking"
    annotation(Placement(transformation(extent={{105, 14}, {115, 24}})));
  Interfaces.RealOutput wheelset_load(final unit="N") "Load of the wheelset on the roller"
    annotation(Placement(transformation(extent={{105, 1}, {115, 11}})));
  Interfaces.RealOutput cylinder_pressure(final unit="Pa") "Pressure in the cylinders"
    annotation(Placement(transformation(extent={{105, -11}, {115, -1}})));
  Interfaces.RealOutput pad_force(final unit="N") "Normal force of both pads of one unit"
    annotation(Placement(transformation(extent={{105, -24}, {115, -14}})));
  Interfaces.RealOutput pad_friction(final unit="1") "Friction coefficient of the pads"
    annotation(Placement(transformation(extent={{105, -36}, {115, -26}})));
  Interfaces.RealOutput disc_temperature(final unit="K") "Temperature of the bulk of the discs"
    annotation(Placement(transformation(extent={{105, -49}, {115, -39}})));
  Interfaces.RealOutput brake_torque(final unit="N.m") "Torque that the brake exerts"
    annotation(Placement(transformation(extent={{105, -61}, {115, -51}})));
  Interfaces.RealOutput drive_torque(final unit="N.m") "Torque of the roller's drive, driving positive"
    annotation(Placement(transformation(extent={{105, -74}, {115, -64}})));
  Interfaces.BooleanOutput locked "= true, if the wheelset is locked"
    annotation(Placement(transformation(extent={{105, -86}, {115, -76}})));
  Interfaces.BooleanOutput standstill "= true, if the roller is at rest"
    annotation(Placement(transformation(extent={{105, -99}, {115, -89}})));
protected
  final parameter Data.Creep creep = Data.Creep(
    k_A=k_A, k_S=k_S, A=A_falling, B=B_falling, r_rail=r_rail, curvature_rail=1/r_roller, E=E_steel, nu=nu_steel,
    v_small=v_small) "Contact of wheel and roller";
  final parameter Data.Resistance resistance = Data.Resistance(
    mu_bearing=mu_bearing, r_bearing=r_bearing, e_rolling=e_rolling) "Bearings and rolling";
  final parameter Data.Pad pads = Data.Pad(
    speed_effect=speed_effect, pad_speed_nominal=pad_speed_nominal, temperature_effect=temperature_effect,
    force_effect=force_effect, pad_force_nominal=pad_force_nominal, E_settle=E_settle, T_settle=T_settle) "Pads";
  final parameter Data.Drag drag = Data.Drag(c_drag=c_drag, A_drag=A_drag, rho_air=rho_air) "Air";
  Components.CarBody body(m=m_imitated, start_speed=start_speed, drag=drag) "Roller and drive: the wagon"
    annotation(Placement(transformation(extent={{-20, 40}, {20, 80}})));
  Components.Rest rest(final n=1) "Detection of standstill"
    annotation(Placement(transformation(extent={{-80, 40}, {-40, 80}})));
  Components.Axle wheelset(
    final n=1, J=J, r_wheel=r_wheel, n_units=n_units, r_friction=r_friction, mu_b_nominal=mu_b_nominal,
    mu_b_start=mu_b_start, T_disc_start=T_disc_start, start_speed=start_speed, creep=creep, resistance=resistance,
    pads=pads) "Wheelset on the roller"
    annotation(Placement(transformation(extent={{-20, -20}, {20, 20}})));
  Types.Length s(start=0, fixed=true, nominal=1) "Distance that the surface has travelled";
equation
  connect(wheelset.box, body.pivot) annotation(Line(points={{0, 22}, {0, 38}}, color={0, 0, 127}));
  wheelset_load = load*(1 + load_ripple*sin(distance/r_roller));
  wheelset.load = {wheelset_load};
  wheelset.mu0 = {mu0};
  wheelset.pad_force = pad_force;
  wheelset.standstill = standstill;
  wheelset_speed = wheelset.group.w;
  slip = wheelset.group.slip;
  contact_force = wheelset.F[1];
  adhesion = wheelset.group.adhesion;
  pad_friction = wheelset.group.pad_friction;
  disc_temperature = wheelset.group.disc_temperature;
  brake_torque = wheelset.group.brake_torque;
  locked = wheelset.group.locked;

  body.track_force = 0;
  body.standstill = standstill;
  rest.v = {body.v};
  rest.track_force = 0;
  rest.capacity = wheelset.totals.capacity;
  der(s) = speed;
  distance = s;
  speed = body.v;
  acceleration = body.a;
  standstill = rest.standstill;
  drive_torque = J_roller*acceleration/r_roller + r_roller*contact_force;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Ellipse(extent={{-35, 70}, {35, 0}}, lineColor={0, 0, 127}),
        Ellipse(extent={{-45, 0}, {45, -90}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The rig of Schwarz and Keck (2020, section 3): the wheelset turns and slides on a roller whose drive
provides the difference between the roller and the mass and drag of a wagon. The defaults imitate 20
t on a load of 10 t, as equation (5) of that paper
has it
(one of two wheelsets brakes the wagon): der(v) = -adhesion g/2 - drag/m.
</p>
<p>
The contact is Polach's on the ellipse of a wheel on a roller. The load swings once each turn of the roller by
<code>load_ripple</code>: rollers are not perfectly round, and load cells measure that.
</p>
<h4>Limitations</h4>
<p>
The drive has neither lag nor limit; <code>drive_torque</code> is the torque that it would have to provide. The data of
the
rig are not published: mass,
load, inertias and brake are estimates of the size of a mainline wheelset.
</p>
</html>"));
end PartialRollerRig;
