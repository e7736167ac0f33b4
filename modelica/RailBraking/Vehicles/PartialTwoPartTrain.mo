within RailBraking.Vehicles;
partial block PartialTwoPartTrain "Two-part train with a Jacobs bogie; what fills the brake cylinders is left open"
  parameter Types.Velocity speed_start(min=0) = 22.222222222222222 "Speed at the start"
    annotation(Dialog(group="Start"));
  parameter Types.Ratio wheelsets_per_group[4] = {2, 1, 1, 2}
    "Number of wheelsets that turn as one, leading group first; a description, no value to change"
    annotation(Dialog(group="Formation"));
  parameter Types.Ratio wheelsets_per_car[2] = {3, 3}
    "Number of wheelsets of each car, of the bogie they share one each; a description, no value to change"
    annotation(Dialog(group="Formation"));
  parameter Types.Length wheelset_position[6] = {0, 1.9, 15.625, 18.275, 32, 33.9}
    "Distance of each wheelset behind the leading one; a description, no value to change"
    annotation(Dialog(group="Formation"));
  parameter Types.Mass m_wheelset[6](each min=1e-3) = {13400, 14100, 14500, 14500, 14100, 13400}
    "Mass that each wheelset carries on the rail, its own included" annotation(Dialog(group="Masses"));
  parameter Types.Mass m_unsprung[6](each min=0) = {1500, 1500, 1300, 1300, 1500, 1500} "Mass of each wheelset itself"
    annotation(Dialog(group="Masses"));
  parameter Types.Mass m_frame[3](each min=1e-3) = {3500, 2800, 3500} "Mass of each bogie frame"
    annotation(Dialog(group="Masses"));
  parameter Types.Inertia I_frame[3](each min=1e-3) = {2200, 2300, 2200} "Pitch inertia of each bogie frame"
    annotation(Dialog(group="Masses"));
  parameter Types.Inertia J[4](each min=1e-3) = {222, 209, 209, 222} "Inertia of each group about its axles"
    annotation(Dialog(group="Masses"));
  parameter Types.Length r_wheel[4](each min=1e-3) = {0.38, 0.38, 0.38, 0.38} "Rolling radius of each group"
    annotation(Dialog(group="Geometry"));
  parameter Types.Length wheelbase[3](each min=1e-3) = {1.9, 2.65, 1.9} "Distance of the wheelsets of each bogie"
    annotation(Dialog(group="Geometry"));
  parameter Types.Length h_frame = 0.55 "Height of the frames' centres of gravity over the rail"
    annotation(Dialog(group="Geometry"));
  parameter Types.Length h_rod = 0.40 "Height of the traction rods over the rail" annotation(Dialog(group="Geometry"));
  parameter Types.Stiffness k_primary = 2.4e6 "Stiffness of the primary suspension over one wheelset"
    annotation(Dialog(group="Suspension"));
  parameter Types.Damping c_primary = 2.4e4 "Damping of the primary suspension over one wheelset"
    annotation(Dialog(group="Suspension"));
  parameter Types.Ratio n_units[4](each min=0) = {3, 2, 2, 3} "Number of brake units of each group"
    annotation(Dialog(group="Brake"));
  parameter Types.Length r_friction[4](each min=1e-3) = {0.235, 0.220, 0.220, 0.235} "Radius at which the pads rub"
    annotation(Dialog(group="Brake"));
  parameter Types.Pressure p_max[4](each min=0) = {3.4e5, 2.0e5, 2.0e5, 3.4e5} "Largest cylinder pressure of each group"
    annotation(Dialog(group="Brake"));
  parameter Types.Pressure p_start[4] = {0, 0, 0, 0} "Cylinder pressure at the start" annotation(Dialog(group="Start"));
  parameter Types.Area A_piston(min=1e-6) = 0.0324 "Area of a piston" annotation(Dialog(group="Brake"));
  parameter Types.Ratio i_rigging(min=1e-6) = 6 "Force of both pads over force of the piston"
    annotation(Dialog(group="Brake"));
  parameter Types.Ratio eta_rigging(min=0, max=1) = 0.95 "Efficiency of the rigging" annotation(Dialog(group="Brake"));
  parameter Types.Force F_spring = 1200 "Force of return spring and slack adjuster" annotation(Dialog(group="Brake"));
  parameter Types.Volume V_cylinder = 3e-3 "Volume of cylinder and hose of one unit" annotation(Dialog(group="Brake"));
  parameter Types.Pressure p_free(min=1) = 1.01325e5 "Absolute pressure at which free air is counted"
    annotation(Dialog(group="Brake"));
  parameter Types.Ratio mu_b_nominal[4] = {0.35, 0.35, 0.35, 0.35}
    "Pad friction at nominal speed, pressure and temperature"
    annotation(Dialog(group="Pads"));
  parameter Types.Ratio mu_b_start[4] = {0.35, 0.35, 0.35, 0.35} "Pad friction at the start"
    annotation(Dialog(group="Start"));
  parameter Types.Ratio speed_effect = 0.12 "Rise of pad friction from nominal speed to standstill, relative"
    annotation(Dialog(group="Pads"));
  parameter Types.Velocity pad_speed_nominal(min=1e-3) = 13 "Sliding speed at which pad friction is nominal"
    annotation(Dialog(group="Pads"));
  parameter Types.Ratio temperature_effect = 0.10 "Rise of pad friction over the temperature range, relative"
    annotation(Dialog(group="Pads"));
  parameter Types.Temperature temperature_nominal = 333.15 "Disc temperature at which pad friction is nominal"
    annotation(Dialog(group="Pads"));
  parameter Types.TemperatureDifference temperature_range(min=1e-3) = 150
    "Temperature rise at which the effect saturates"
    annotation(Dialog(group="Pads"));
  parameter Types.Ratio force_effect = 0.08 "Loss of pad friction at twice the nominal pad force, relative"
    annotation(Dialog(group="Pads"));
  parameter Types.Force pad_force_nominal(min=1e-3) = 56e3 "Pad force at which pad friction is nominal"
    annotation(Dialog(group="Pads"));
  parameter Types.Energy E_settle(min=1e-3) = 2e5 "Friction energy of one unit in which pad friction settles"
    annotation(Dialog(group="Pads"));
  parameter Types.Time T_settle(min=1e-3) = 3 "Time in which pad friction settles at little power"
    annotation(Dialog(group="Pads"));
  parameter Types.Force F_release(min=1e-3) = 1e3 "Pad force below which pads count as released"
    annotation(Dialog(group="Pads"));
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
  parameter Types.Temperature T_disc_start[4] = {313.15, 313.15, 313.15, 313.15} "Temperature of the discs at the start"
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
  parameter Types.Area A_drag = 10 "Frontal area" annotation(Dialog(group="Resistance"));
  parameter Types.Density rho_air = 1.2 "Density of the air" annotation(Dialog(group="Resistance"));
  parameter Types.Torque tau_small(min=1e-3) = 10
    "Torque by which the track must exceed the brake to turn a locked group"
    annotation(Dialog(tab="Numerics"));
  parameter Types.Force F_small(min=1e-3) = 10 "Force by which the track must exceed what holds the train to move it"
    annotation(Dialog(tab="Numerics"));
  parameter Types.Velocity v_rest(min=1e-6) = 1e-3 "Speed at which the train comes to rest if it can be held"
    annotation(Dialog(tab="Numerics"));

  Interfaces.RealInput mu0[6](each final unit="1", each start=0)
    "Maximum friction coefficient of the rail at each wheelset"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput track_force(final unit="N", start=0) "Force of gradient and curve, forward"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));

  Interfaces.RealOutput distance(final unit="m") "Distance travelled"
    annotation(Placement(transformation(extent={{107, 93}, {113, 99}})));
  Interfaces.RealOutput speed(final unit="m/s") "Speed of the train"
    annotation(Placement(transformation(extent={{107, 84}, {113, 90}})));
  Interfaces.RealOutput acceleration(final unit="m/s2") "Acceleration of the train"
    annotation(Placement(transformation(extent={{107, 75}, {113, 81}})));
  Interfaces.RealOutput wheelset_speed[4](each final unit="rad/s") "Angular velocity of each group"
    annotation(Placement(transformation(extent={{107, 67}, {113, 73}})));
  Interfaces.RealOutput slip[4](each final unit="1") "Slip of each group, 0 rolling, 1 locked"
    annotation(Placement(transformation(extent={{107, 58}, {113, 64}})));
  Interfaces.RealOutput adhesion[6](each final unit="1") "Adhesion used by each wheelset, positive in braking"
    annotation(Placement(transformation(extent={{107, 49}, {113, 55}})));
  Interfaces.RealOutput group_adhesion[4](each final unit="1") "Adhesion used by each group"
    annotation(Placement(transformation(extent={{107, 40}, {113, 46}})));
  Interfaces.RealOutput wheelset_load[6](each final unit="N") "Load of each wheelset on the rail"
    annotation(Placement(transformation(extent={{107, 32}, {113, 38}})));
  Interfaces.RealOutput deflection[6](each final unit="m")
    "Deflection of the primary suspension, change from static, compression positive"
    annotation(Placement(transformation(extent={{107, 23}, {113, 29}})));
  Interfaces.RealOutput cylinder_pressure[4](each final unit="Pa") "Pressure in the cylinders of each group"
    annotation(Placement(transformation(extent={{107, 14}, {113, 20}})));
  Interfaces.RealOutput pad_force[4](each final unit="N") "Normal force of both pads of one unit"
    annotation(Placement(transformation(extent={{107, 6}, {113, 12}})));
  Interfaces.RealOutput pad_friction[4](each final unit="1") "Friction coefficient of the pads"
    annotation(Placement(transformation(extent={{107, -3}, {113, 3}})));
  Interfaces.RealOutput disc_temperature[4](each final unit="K") "Temperature of the bulk of the discs"
    annotation(Placement(transformation(extent={{107, -12}, {113, -6}})));
  Interfaces.RealOutput disc_surface_temperature[4](each final unit="K") "Temperature of the surface of the discs"
    annotation(Placement(transformation(extent={{107, -20}, {113, -14}})));
  Interfaces.RealOutput brake_torque[4](each final unit="N.m") "Torque that the brake exerts on each group"
    annotation(Placement(transformation(extent={{107, -29}, {113, -23}})));
  Interfaces.RealOutput air_used(final unit="m3") "Free air taken from the supply since the start"
    annotation(Placement(transformation(extent={{107, -38}, {113, -32}})));
  Interfaces.RealOutput contact_heat(final unit="J") "Heat made between wheels and rails since the start"
    annotation(Placement(transformation(extent={{107, -46}, {113, -40}})));
  Interfaces.RealOutput pad_heat(final unit="J") "Heat made between pads and discs since the start"
    annotation(Placement(transformation(extent={{107, -55}, {113, -49}})));
  Interfaces.RealOutput damper_heat(final unit="J") "Heat made in the primary suspension since the start"
    annotation(Placement(transformation(extent={{107, -64}, {113, -58}})));
  Interfaces.RealOutput resistance_work(final unit="J")
    "Work against drag, bearings, rolling resistance and track force since the start"
    annotation(Placement(transformation(extent={{107, -73}, {113, -67}})));
  Interfaces.RealOutput kinetic_energy(final unit="J") "Energy of motion along the track and of rotation"
    annotation(Placement(transformation(extent={{107, -81}, {113, -75}})));
  Interfaces.BooleanOutput locked[4] "= true, if the group does not turn"
    annotation(Placement(transformation(extent={{107, -90}, {113, -84}})));
  Interfaces.BooleanOutput standstill "= true, if the train stands"
    annotation(Placement(transformation(extent={{107, -99}, {113, -93}})));

protected
  final parameter Types.Volume V_group[4] = V_cylinder*n_units "Volume of all cylinders and hoses of each group";
  Components.TrainBody body(
    m=sum(m_wheelset), c_drag=c_drag, A_drag=A_drag, rho_air=rho_air, v_rest=v_rest, F_small=F_small,
    v_start=speed_start)
    "All masses along the track"
    annotation(Placement(transformation(extent={{-73, 33}, {-33, 73}})));
  Components.Wheelsets leading(
    final n=2, J=J[1], r=r_wheel[1], r_rail=r_rail, E=E_steel, nu=nu_steel, k_A=k_A, k_S=k_S, A=A_falling, B=B_falling,
    v_small=v_small, mu_bearing=mu_bearing, r_bearing=r_bearing, e_rolling=e_rolling, tau_small=tau_small,
    w_start=speed_start/r_wheel[1]) "Coupled wheelsets of the leading motor bogie"
    annotation(Placement(transformation(extent={{-20, 33}, {20, 73}})));
  Components.Wheelsets jacobs_front(
    final n=1, J=J[2], r=r_wheel[2], r_rail=r_rail, E=E_steel, nu=nu_steel, k_A=k_A, k_S=k_S, A=A_falling, B=B_falling,
    v_small=v_small, mu_bearing=mu_bearing, r_bearing=r_bearing, e_rolling=e_rolling, tau_small=tau_small,
    w_start=speed_start/r_wheel[2]) "Front wheelset of the Jacobs bogie"
    annotation(Placement(transformation(extent={{33, 33}, {73, 73}})));
  Components.Wheelsets jacobs_rear(
    final n=1, J=J[3], r=r_wheel[3], r_rail=r_rail, E=E_steel, nu=nu_steel, k_A=k_A, k_S=k_S, A=A_falling, B=B_falling,
    v_small=v_small, mu_bearing=mu_bearing, r_bearing=r_bearing, e_rolling=e_rolling, tau_small=tau_small,
    w_start=speed_start/r_wheel[3]) "Rear wheelset of the Jacobs bogie"
    annotation(Placement(transformation(extent={{-73, -20}, {-33, 20}})));
  Components.Wheelsets trailing(
    final n=2, J=J[4], r=r_wheel[4], r_rail=r_rail, E=E_steel, nu=nu_steel, k_A=k_A, k_S=k_S, A=A_falling, B=B_falling,
    v_small=v_small, mu_bearing=mu_bearing, r_bearing=r_bearing, e_rolling=e_rolling, tau_small=tau_small,
    w_start=speed_start/r_wheel[4]) "Coupled wheelsets of the trailing motor bogie"
    annotation(Placement(transformation(extent={{-20, -20}, {20, 20}})));
  Components.GroupBrake brake[4](
    n_units=n_units, r_friction=r_friction,
    pad(
      mu_nominal=mu_b_nominal, mu_start=mu_b_start,
      each speed_effect=speed_effect, each pad_speed_nominal=pad_speed_nominal,
      each temperature_effect=temperature_effect, each temperature_nominal=temperature_nominal,
      each temperature_range=temperature_range, each force_effect=force_effect,
      each pad_force_nominal=pad_force_nominal, each E_settle=E_settle, each T_settle=T_settle,
      each F_release=F_release),
    disc(
      each m=m_disc, each m_surface=m_disc_surface, each c_p=c_disc, each G=G_disc,
      each G_rest=G_rest, each G_speed=G_speed,
      each pad_share=pad_share, each T_ambient=T_ambient, T_start=T_disc_start)) "Brake units of each group"
    annotation(Placement(transformation(extent={{33, -20}, {73, 20}})));
  Components.BogieFrame frame[3](
    m_wheelset={{m_wheelset[1], m_wheelset[2]}, {m_wheelset[3], m_wheelset[4]}, {m_wheelset[5], m_wheelset[6]}},
    m_unsprung={{m_unsprung[1], m_unsprung[2]}, {m_unsprung[3], m_unsprung[4]}, {m_unsprung[5], m_unsprung[6]}},
    m_frame=m_frame, I_frame=I_frame, wheelbase=wheelbase,
    each h_frame=h_frame, each h_rod=h_rod, each k=k_primary, each c=c_primary,
    r_wheel={r_wheel[1], (r_wheel[2] + r_wheel[3])/2, r_wheel[4]})
    "Frames of the leading, the Jacobs and the trailing bogie"
    annotation(Placement(transformation(extent={{-73, -73}, {-33, -33}})));
  Types.Force F[6] "Braking force of the track on each wheelset";
  Types.Volume air(start=0, fixed=true) "Free air taken from the supply";
  Types.VolumeFlow air_flow "Free air taken from the supply, a time";
  Types.Energy heat_contact(start=0, fixed=true) "Heat made between wheels and rails";
  Types.Energy heat_pad(start=0, fixed=true) "Heat made between pads and discs";
  Types.Energy heat_damper(start=0, fixed=true) "Heat made in the primary suspension";
  Types.Energy work_resistance(start=0, fixed=true) "Work against resistances and track force";
equation
  leading.v = body.v;
  leading.load = {frame[1].load[1], frame[1].load[2]};
  leading.mu0 = {mu0[1], mu0[2]};
  leading.brake_torque = brake[1].torque;
  leading.standstill = body.standstill;
  jacobs_front.v = body.v;
  jacobs_front.load = {frame[2].load[1]};
  jacobs_front.mu0 = {mu0[3]};
  jacobs_front.brake_torque = brake[2].torque;
  jacobs_front.standstill = body.standstill;
  jacobs_rear.v = body.v;
  jacobs_rear.load = {frame[2].load[2]};
  jacobs_rear.mu0 = {mu0[4]};
  jacobs_rear.brake_torque = brake[3].torque;
  jacobs_rear.standstill = body.standstill;
  trailing.v = body.v;
  trailing.load = {frame[3].load[1], frame[3].load[2]};
  trailing.mu0 = {mu0[5], mu0[6]};
  trailing.brake_torque = brake[4].torque;
  trailing.standstill = body.standstill;
  F = {leading.F[1], leading.F[2], jacobs_front.F[1], jacobs_rear.F[1], trailing.F[1], trailing.F[2]};

  for i in 1:4 loop
    brake[i].pad_force = pad_force[i];
    brake[i].w = wheelset_speed[i];
    brake[i].speed = body.v;
    pad_friction[i] = brake[i].pad.mu;
    disc_temperature[i] = brake[i].disc.temperature;
    disc_surface_temperature[i] = brake[i].disc.temperature_surface;
  end for;
  for i in 1:3 loop
    frame[i].a = body.a;
    frame[i].F = F[2*i - 1] + F[2*i];
    wheelset_load[2*i - 1] = frame[i].load[1];
    wheelset_load[2*i] = frame[i].load[2];
    deflection[2*i - 1] = frame[i].dz[1];
    deflection[2*i] = frame[i].dz[2];
  end for;
  frame[1].torque = brake_torque[1];
  frame[2].torque = brake_torque[2] + brake_torque[3];
  frame[3].torque = brake_torque[4];
  body.F = sum(F);
  body.track_force = track_force;
  body.capacity = leading.capacity + jacobs_front.capacity + jacobs_rear.capacity + trailing.capacity;

  distance = body.s;
  speed = body.v;
  acceleration = body.a;
  wheelset_speed = {leading.w, jacobs_front.w, jacobs_rear.w, trailing.w};
  slip = {leading.contact[1].slip, jacobs_front.contact[1].slip, jacobs_rear.contact[1].slip, trailing.contact[1].slip};
  for i in 1:6 loop
    adhesion[i] = F[i]/wheelset_load[i];
  end for;
  group_adhesion = {
    sum(leading.F)/sum(leading.load), sum(jacobs_front.F)/sum(jacobs_front.load),
    sum(jacobs_rear.F)/sum(jacobs_rear.load), sum(trailing.F)/sum(trailing.load)};
  brake_torque = {leading.torque, jacobs_front.torque, jacobs_rear.torque, trailing.torque};
  locked = {leading.locked, jacobs_front.locked, jacobs_rear.locked, trailing.locked};
  standstill = body.standstill;

  der(air) = air_flow;
  der(heat_contact) = leading.contact_power + jacobs_front.contact_power + jacobs_rear.contact_power
    + trailing.contact_power;
  der(heat_pad) = sum(brake.heat_flow);
  der(heat_damper) = sum(frame.damper_power);
  der(work_resistance) = body.resistance_power + leading.resistance_power + jacobs_front.resistance_power
    + jacobs_rear.resistance_power + trailing.resistance_power;
  air_used = air;
  contact_heat = heat_contact;
  pad_heat = heat_pad;
  damper_heat = heat_damper;
  resistance_work = work_resistance;
  kinetic_energy = sum(m_wheelset)*speed^2/2 + sum(J[i]*wheelset_speed[i]^2 for i in 1:4)/2;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Rectangle(extent={{-90, 40}, {-2, -40}}, lineColor={0, 0, 127}),
        Rectangle(extent={{2, 40}, {90, -40}}, lineColor={0, 0, 127}),
        Ellipse(extent={{-87, -43}, {-63, -67}}, lineColor={0, 0, 127}),
        Ellipse(extent={{-62, -43}, {-38, -67}}, lineColor={0, 0, 127}),
        Ellipse(extent={{-24, -43}, {0, -67}}, lineColor={0, 0, 127}),
        Ellipse(extent={{0, -43}, {24, -67}}, lineColor={0, 0, 127}),
        Ellipse(extent={{38, -43}, {62, -67}}, lineColor={0, 0, 127}),
        Ellipse(extent={{63, -43}, {87, -67}}, lineColor={0, 0, 127}),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The plant of Schwarz, Posielek and Goetjes (see References), equations (1) to (6): speed, angular velocity of four
groups, pad friction of four groups and the deflections of six primary suspensions with their rates. Disc
temperatures, cylinder pressures, distance, air and four energies come on top.
</p>
<h4>Implementation</h4>
<p>
Energies balance exactly: <code>kinetic_energy + contact_heat + pad_heat + resistance_work</code> is constant, apart
from what the
solver loses and 0.04 J when the train comes to rest. <code>resistance_work</code> counts the work against drag,
bearing and rolling
resistance and, with its sign, the track force. <code>damper_heat</code> stands beside that sum: pitching frames are
moved by
the braking forces but do not slow the train, see <a
href=\"modelica://RailBraking.Components.BogieFrame\">BogieFrame</a>;
that is some ten joules in a smooth stop of twenty megajoules, and 15 kJ, 0.07 %, where slip control throws the brakes
on and off throughout.
</p>
<h4>Limitations</h4>
<p>
Straight motion in the plane of the rails; car bodies neither bounce nor pitch; forward motion only. The slip of
a locked group is below one when the train is slower than ten times <code>v_small</code> (0.995 at 1 m/s).
</p>
</html>"));
end PartialTwoPartTrain;
