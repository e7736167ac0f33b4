within RailBraking.Vehicles;
partial block PartialTrain "Parameters, inputs and outputs of every train made of cars, bogies and couplers"
  extends Icons.Vehicle;
  parameter Integer cars(min=1) = 1 "Number of cars" annotation(Evaluate=true, Dialog(group="Formation"));
  parameter Integer bodies(min=1) = cars "Number of bodies joined by couplers; rigidly joined cars are one body"
    annotation(Evaluate=true, Dialog(group="Formation"));
  parameter Integer bogies(min=1) = 1 "Number of bogies" annotation(Evaluate=true, Dialog(group="Formation"));
  parameter Integer groups(min=1) = 1 "Number of groups of wheelsets that turn as one"
    annotation(Evaluate=true, Dialog(group="Formation"));
  parameter Integer wheelsets(min=1) = 1 "Number of wheelsets" annotation(Evaluate=true, Dialog(group="Formation"));
  final parameter Integer couplers = bodies - 1 "Number of couplers";
  parameter Types.Velocity start_speed(min=0) = 80/3.6 "Speed at the start"
    annotation(Dialog(group="Start"));
  parameter Types.Ratio wheelsets_per_group[groups] = fill(wheelsets/groups, groups)
    "Number of wheelsets that turn as one, leading group first; a description that cannot be changed"
    annotation(Dialog(group="Formation"));
  parameter Types.Ratio wheelsets_per_car[cars] = fill(wheelsets/cars, cars)
    "Number of wheelsets of each car; a description that cannot be changed" annotation(Dialog(group="Formation"));
  parameter Types.Length wheelset_position[wheelsets] = {3.0*(i - 1) for i in 1:wheelsets}
    "Distance of each wheelset behind the leading one; a description that cannot be changed"
    annotation(Dialog(group="Formation"));
  parameter Types.Mass m_wheelset[wheelsets](each min=1e-3) = {12000 for i in 1:wheelsets}
    "Mass that each wheelset carries on the rail, including its own"
    annotation(Dialog(group="Masses"));
  parameter Types.Mass m_unsprung[wheelsets](each min=0) = {1500 for i in 1:wheelsets} "Mass of each wheelset alone"
    annotation(Dialog(group="Masses"));
  parameter Types.Mass m_frame[bogies](each min=1e-3) = {3000 for i in 1:bogies} "Mass of each bogie frame"
    annotation(Dialog(group="Masses"));
  parameter Types.Inertia I_frame[bogies](each min=1e-3) = {2000 for i in 1:bogies} "Pitch inertia of each bogie frame"
    annotation(Dialog(group="Masses"));
  parameter Types.Inertia J[groups](each min=1e-3) = {110 for i in 1:groups} "Inertia of each group about its axles"
    annotation(Dialog(group="Masses"));
  parameter Types.Length r_wheel[groups](each min=1e-3) = {0.42 for i in 1:groups} "Rolling radius of each group"
    annotation(Dialog(group="Geometry"));
  parameter Types.Length wheelbase[bogies](each min=1e-3) = {2.2 for i in 1:bogies}
    "Distance of the first and the last wheelset of each bogie"
    annotation(Dialog(group="Geometry"));
  parameter Types.Ratio n_units[groups](each min=0) = {2 for i in 1:groups} "Number of brake units of each group"
    annotation(Dialog(group="Brake"));
  parameter Types.Length r_friction[groups](each min=1e-3) = {0.24 for i in 1:groups} "Friction radius of the pads"
    annotation(Dialog(group="Brake"));
  parameter Types.Pressure p_max[groups](each min=0) = {3.0e5 for i in 1:groups}
    "Maximum cylinder pressure of each group"
    annotation(Dialog(group="Brake"));
  parameter Types.Pressure p_start[groups] = {0 for i in 1:groups} "Cylinder pressure at the start"
    annotation(Dialog(group="Start"));
  parameter Types.Volume V_cylinder = 3e-3 "Volume of cylinder and hose of one unit" annotation(Dialog(group="Brake"));
  parameter Types.Pressure p_free(min=1) = 1.01325e5 "Absolute pressure at which free air is counted"
    annotation(Dialog(group="Brake"));
  parameter Types.Ratio mu_b_nominal[groups] = {0.35 for i in 1:groups}
    "Pad friction at nominal speed, pressure and temperature"
    annotation(Dialog(group="Pads"));
  parameter Types.Ratio mu_b_start[groups] = {0.35 for i in 1:groups} "Pad friction at the start"
    annotation(Dialog(group="Start"));
  parameter Types.Mass m_disc(min=1e-3) = 110 "Mass of a disc" annotation(Dialog(group="Discs"));
  parameter Types.Mass m_disc_surface(min=1e-3) = 12 "Mass of the friction rings near the surface"
    annotation(Dialog(group="Discs"));
  parameter Types.SpecificHeat c_disc(min=1e-3) = 500 "Specific heat capacity of the discs"
    annotation(Dialog(group="Discs"));
  parameter Types.HeatConductance G_disc = 2500 "Heat conductance between surface and bulk"
    annotation(Dialog(group="Discs"));
  parameter Types.HeatConductance G_rest = 20 "Heat conductance of a disc to the air at rest"
    annotation(Dialog(group="Discs"));
  parameter Types.SpeedHeatConductance G_speed = 2.5 "Rise of that conductance with speed"
    annotation(Dialog(group="Discs"));
  parameter Types.Ratio pad_share(min=0, max=1) = 0.07 "Share of the friction heat that stays in the pads"
    annotation(Dialog(group="Discs"));
  parameter Types.Temperature T_ambient = 293.15 "Temperature of the air" annotation(Dialog(group="Discs"));
  parameter Types.Temperature T_disc_start[groups] = {313.15 for i in 1:groups} "Temperature of the discs at the start"
    annotation(Dialog(group="Start"));
  parameter Types.Ratio k_A(min=0, max=1) = 0.3 "Polach: reduction of the creep stiffness in the area of adhesion"
    annotation(Dialog(group="Contact"));
  parameter Types.Ratio k_S(min=0, max=1) = 0.1 "Polach: reduction of the creep stiffness in the area of slip"
    annotation(Dialog(group="Contact"));
  parameter Types.Ratio A_falling(min=0, max=1) = 0.4 "Polach: friction at infinite slip speed over maximum friction"
    annotation(Dialog(group="Contact"));
  parameter Types.InverseVelocity B_falling(min=0) = 0.2 "Polach: rate at which friction falls with slip speed"
    annotation(Dialog(group="Contact"));
  parameter Types.Length r_rail(min=1e-3) = 0.30 "Radius of the rail head across the track"
    annotation(Dialog(group="Contact"));
  parameter Types.Modulus E_steel(min=1e-3) = 2.1e11 "Young's modulus of wheel and rail"
    annotation(Dialog(group="Contact"));
  parameter Types.Ratio nu_steel(min=0, max=0.5) = 0.28 "Poisson's ratio of wheel and rail"
    annotation(Dialog(group="Contact"));
  parameter Types.Velocity v_small(min=1e-3) = 0.1 "Speed below which slip is regularised"
    annotation(Dialog(group="Contact"));
  parameter Types.Ratio mu_bearing(min=1e-9) = 0.0018 "Friction coefficient of the axle bearings"
    annotation(Dialog(group="Resistance"));
  parameter Types.Length r_bearing(min=1e-9) = 0.065 "Radius of the axle bearings"
    annotation(Dialog(group="Resistance"));
  parameter Types.Length e_rolling = 0.0004 "Lever arm of the rolling resistance"
    annotation(Dialog(group="Resistance"));
  parameter Types.Ratio c_drag = 0.9 "Drag coefficient" annotation(Dialog(group="Resistance"));
  parameter Types.Area A_drag = 10 "Frontal area of the train; each body has an equal share of its drag"
    annotation(Dialog(group="Resistance"));
  parameter Types.Density rho_air = 1.2 "Density of the air" annotation(Dialog(group="Resistance"));
  parameter Types.Torque tau_small(min=1e-3) = 10
    "Excess of the track's torque over the brake's that turns a locked group"
    annotation(Dialog(tab="Numerics"));
  parameter Types.Force F_small(min=1e-3) = 10 "Excess of the track force over the holding force that moves the train"
    annotation(Dialog(tab="Numerics"));
  parameter Types.Velocity v_rest(min=1e-6) = 1e-3 "Speed below which the train comes to rest if it can be held"
    annotation(Dialog(tab="Numerics"));

  Interfaces.RealInput mu0[wheelsets](each final unit="1", each start=0)
    "Maximum friction coefficient of the rail at each wheelset"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput track_force(final unit="N", start=0) "Force of gradient and curve, forward"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));

  Interfaces.RealOutput distance(final unit="m") "Distance travelled"
    annotation(Placement(transformation(extent={{107, 93}, {113, 99}})));
  Interfaces.RealOutput speed(final unit="m/s") "Speed of the train's centre of gravity"
    annotation(Placement(transformation(extent={{107, 85}, {113, 91}})));
  Interfaces.RealOutput acceleration(final unit="m/s2") "Acceleration of the train's centre of gravity"
    annotation(Placement(transformation(extent={{107, 77}, {113, 83}})));
  Interfaces.RealOutput wheelset_speed[groups](each final unit="rad/s") "Angular velocity of each group"
    annotation(Placement(transformation(extent={{107, 70}, {113, 76}})));
  Interfaces.RealOutput slip[groups](each final unit="1") "Slip of each group, 0 rolling, 1 locked"
    annotation(Placement(transformation(extent={{107, 62}, {113, 68}})));
  Interfaces.RealOutput adhesion[wheelsets](each final unit="1") "Adhesion used by each wheelset, positive in braking"
    annotation(Placement(transformation(extent={{107, 54}, {113, 60}})));
  Interfaces.RealOutput group_adhesion[groups](each final unit="1") "Adhesion used by each group"
    annotation(Placement(transformation(extent={{107, 46}, {113, 52}})));
  Interfaces.RealOutput wheelset_load[wheelsets](each final unit="N") "Load of each wheelset on the rail"
    annotation(Placement(transformation(extent={{107, 38}, {113, 44}})));
  Interfaces.RealOutput deflection[wheelsets](each final unit="m")
    "Deflection of the primary suspension, change from static, compression positive"
    annotation(Placement(transformation(extent={{107, 31}, {113, 37}})));
  Interfaces.RealOutput cylinder_pressure[groups](each final unit="Pa") "Cylinder pressure of each group"
    annotation(Placement(transformation(extent={{107, 23}, {113, 29}})));
  Interfaces.RealOutput pad_force[groups](each final unit="N") "Normal force of both pads of one unit"
    annotation(Placement(transformation(extent={{107, 15}, {113, 21}})));
  Interfaces.RealOutput pad_friction[groups](each final unit="1") "Friction coefficient of the pads"
    annotation(Placement(transformation(extent={{107, 7}, {113, 13}})));
  Interfaces.RealOutput disc_temperature[groups](each final unit="K") "Temperature of the bulk of the discs"
    annotation(Placement(transformation(extent={{107, -1}, {113, 5}})));
  Interfaces.RealOutput disc_surface_temperature[groups](each final unit="K") "Temperature of the surface of the discs"
    annotation(Placement(transformation(extent={{107, -8}, {113, -2}})));
  Interfaces.RealOutput brake_torque[groups](each final unit="N.m") "Torque that the brake exerts on each group"
    annotation(Placement(transformation(extent={{107, -16}, {113, -10}})));
  Interfaces.RealOutput air_used(final unit="m3") "Free air taken from the supply since the start"
    annotation(Placement(transformation(extent={{107, -24}, {113, -18}})));
  Interfaces.RealOutput contact_heat(final unit="J") "Heat generated between wheels and rails since the start"
    annotation(Placement(transformation(extent={{107, -32}, {113, -26}})));
  Interfaces.RealOutput pad_heat(final unit="J") "Heat generated between pads and discs since the start"
    annotation(Placement(transformation(extent={{107, -40}, {113, -34}})));
  Interfaces.RealOutput damper_heat(final unit="J") "Heat generated in the primary suspension since the start"
    annotation(Placement(transformation(extent={{107, -47}, {113, -41}})));
  Interfaces.RealOutput resistance_work(final unit="J")
    "Work against drag, bearings, rolling resistance and track force since the start"
    annotation(Placement(transformation(extent={{107, -55}, {113, -49}})));
  Interfaces.RealOutput coupler_work(final unit="J")
    "Work that the cars have put into the couplers since the start, stored or dissipated"
    annotation(Placement(transformation(extent={{107, -63}, {113, -57}})));
  Interfaces.RealOutput kinetic_energy(final unit="J") "Energy of motion along the track and of rotation"
    annotation(Placement(transformation(extent={{107, -71}, {113, -65}})));
  Interfaces.RealOutput coupler_force[couplers](each final unit="N") "Force in each coupler, positive when it pulls"
    annotation(Placement(transformation(extent={{107, -79}, {113, -73}})));
  Interfaces.BooleanOutput locked[groups] "= true, if the group is locked"
    annotation(Placement(transformation(extent={{107, -86}, {113, -80}})));
  Interfaces.BooleanOutput standstill "= true, if the train is at rest"
    annotation(Placement(transformation(extent={{107, -94}, {113, -88}})));

protected
  final parameter Data.Creep creep = Data.Creep(
    k_A=k_A, k_S=k_S, A=A_falling, B=B_falling, r_rail=r_rail, E=E_steel, nu=nu_steel, v_small=v_small) "Contact";
  Data.CreepCurve curve[wheelsets] = {
    Data.CreepCurve(k_A=k_A, k_S=k_S, A=A_falling, B=B_falling) for i in 1:wheelsets}
    "Shape of the creep curve at each wheelset";
  final parameter Data.Resistance resistance = Data.Resistance(
    mu_bearing=mu_bearing, r_bearing=r_bearing, e_rolling=e_rolling) "Bearings and rolling";
  final parameter Data.Disc discs = Data.Disc(
    m=m_disc, m_surface=m_disc_surface, c_p=c_disc, G=G_disc, G_rest=G_rest, G_speed=G_speed, pad_share=pad_share,
    T_ambient=T_ambient) "Discs";
  final parameter Data.Drag drag = Data.Drag(c_drag=c_drag, A_drag=A_drag/bodies, rho_air=rho_air) "Air";
  final parameter Types.Mass m_train = sum(m_wheelset) "Mass of the train, without rotating masses";
  final parameter Types.Volume V_group[groups] = V_cylinder*n_units "Volume of all cylinders and hoses of each group";
  Components.Rest rest(final n=bodies, v_rest=v_rest, F_small=F_small) "Detection of standstill"
    annotation(Placement(transformation(extent={{-100, 80}, {-80, 100}})));
  Types.Velocity v[bodies] "Speed of each body";
  Types.Acceleration a[bodies] "Acceleration of each body";
  Types.Mass m_body[bodies] "Mass of each body; together that of the train";
  Data.WheelsetSignals wheelset[wheelsets] "Signals of each wheelset, leading first";
  Data.GroupSignals group[groups] "Signals of each group, leading first";
  Data.Totals totals "Sums over the train";
  Types.VolumeFlow air_flow "Free air taken from the supply per time";
  Types.Power coupler_power "Power that the cars put into the couplers";
  Types.Length s(start=0, fixed=true, nominal=1) "Distance travelled";
  Types.Volume air(start=0, fixed=true, nominal=1e-3) "Free air taken from the supply";
  Types.Energy heat_contact(start=0, fixed=true, nominal=1e6) "Heat generated between wheels and rails";
  Types.Energy heat_pad(start=0, fixed=true, nominal=1e6) "Heat generated between pads and discs";
  Types.Energy heat_damper(start=0, fixed=true, nominal=1e3) "Heat generated in the primary suspension";
  Types.Energy work_resistance(start=0, fixed=true, nominal=1e6) "Work against resistances and track force";
  Types.Energy work_coupler(start=0, fixed=true, nominal=1e3) "Work put into the couplers";
equation
  rest.v = v;
  rest.track_force = track_force;
  rest.capacity = totals.capacity;
  standstill = rest.standstill;
  speed = m_body*v/m_train;
  acceleration = m_body*a/m_train;
  der(s) = speed;
  distance = s;
  for i in 1:wheelsets loop
    adhesion[i] = wheelset[i].F/wheelset[i].load;
  end for;
  wheelset_load = wheelset.load;
  deflection = wheelset.deflection;
  wheelset_speed = group.w;
  slip = group.slip;
  group_adhesion = group.adhesion;
  pad_friction = group.pad_friction;
  disc_temperature = group.disc_temperature;
  disc_surface_temperature = group.disc_surface_temperature;
  brake_torque = group.brake_torque;
  locked = group.locked;
  kinetic_energy = totals.kinetic_energy;
  der(air) = air_flow;
  der(heat_contact) = totals.contact_power;
  der(heat_pad) = totals.pad_power;
  der(heat_damper) = totals.damper_power;
  der(work_resistance) = totals.resistance_power;
  der(work_coupler) = coupler_power;
  air_used = air;
  contact_heat = heat_contact;
  pad_heat = heat_pad;
  damper_heat = heat_damper;
  resistance_work = work_resistance;
  coupler_work = work_coupler;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-90, 40}, {-2, -40}}, lineColor={0, 0, 127}),
        Rectangle(extent={{2, 40}, {90, -40}}, lineColor={0, 0, 127}),
        Ellipse(extent={{-85, -43}, {-55, -73}}, lineColor={0, 0, 127}),
        Ellipse(extent={{-40, -43}, {-10, -73}}, lineColor={0, 0, 127}),
        Ellipse(extent={{10, -43}, {40, -73}}, lineColor={0, 0, 127}),
        Ellipse(extent={{55, -43}, {85, -73}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The interface of the FMU of a train: parameters, inputs and outputs by the names of the loop, and
the sums over the train. A train extends it with its numbers of components, declares and connects
car bodies, bogies, couplers and cylinders, and assigns <code>wheelset</code>, <code>group</code>
and <code>totals</code>; see <a
href=\"modelica://RailBraking.Vehicles.PartialConsist\">PartialConsist</a> and <a
href=\"modelica://RailBraking.Vehicles.PartialTwoPartTrain\">PartialTwoPartTrain</a>.
</p>
<h4>Implementation</h4>
<p>
Energies balance: <code>kinetic_energy + contact_heat + pad_heat + resistance_work + coupler_work</code> is
constant, except for the error of the solver and for the energy that <a
href=\"modelica://RailBraking.Components.Rest\">Rest</a> discards.
<code>resistance_work</code> counts the work against drag, bearing and rolling resistance and, with its sign, the
track force. <code>damper_heat</code> is not part of that sum: braking forces move pitching frames,
which do not slow the train, see <a
href=\"modelica://RailBraking.Components.BogieFrame\">BogieFrame</a>; in the two-part train
that is some ten joules in a smooth stop of twenty megajoules, and 15 kJ, 0.07 %, in a stop in which
slip control applies and releases the brakes all the time.
</p>
<h4>Limitations</h4>
<p>
Straight motion in the plane of the rails, forward only; car bodies neither bounce nor pitch. The slip of a locked
group is below one when the train is slower than ten times <code>v_small</code> (0.995 at 1 m/s).
</p>
</html>"));
end PartialTrain;
