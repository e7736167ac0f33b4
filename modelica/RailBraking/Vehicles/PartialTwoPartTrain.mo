within RailBraking.Vehicles;
partial block PartialTwoPartTrain "Two-part train with a Jacobs bogie, without the supply of the brake cylinders"
  extends Icons.Vehicle;
  extends PartialUniformTrain(
    final cars=2, final bodies=1, final bogies=3, final groups=4, final wheelsets=6,
    wheelsets_per_group={2, 1, 1, 2}, wheelsets_per_car={3, 3},
    wheelset_position={0, 1.9, 15.625, 18.275, 32, 33.9}, m_wheelset={13400, 14100, 14500, 14500, 14100, 13400},
    m_unsprung={1500, 1500, 1300, 1300, 1500, 1500}, m_frame={3500, 2800, 3500}, I_frame={2200, 2300, 2200},
    J={222, 209, 209, 222}, r_wheel={0.38, 0.38, 0.38, 0.38}, wheelbase={1.9, 2.65, 1.9}, n_units={3, 2, 2, 3},
    r_friction={0.235, 0.220, 0.220, 0.235}, p_max={3.4e5, 2.0e5, 2.0e5, 3.4e5});
  replaceable block TrainContact = Contact.WheelsetContact constrainedby Interfaces.PartialContact
    "Law of the contacts";
  replaceable block TrainShaft = Components.RigidShaft constrainedby Interfaces.PartialShaft
    "Shafts between wheels and brake discs";
  replaceable block TrainRail = Tracks.EvenRail constrainedby Interfaces.PartialRail "Height of the rail";
protected
  Components.CarBody body(m=m_train, start_speed=start_speed, drag=drag) "Both car bodies"
    annotation(Placement(transformation(extent={{-20, 40}, {20, 80}})));
  Components.Bogie leading(
    redeclare block BogieContact = TrainContact, redeclare block BogieShaft = TrainShaft,
    redeclare block BogieRail = TrainRail,
    final n=2, final groups=1, behind=wheelset_position[1:2], m_wheelset=m_wheelset[1:2],
    m_unsprung=m_unsprung[1:2], m_frame=m_frame[1], I_frame=I_frame[1], wheelbase=wheelbase[1], J=J[1:1],
    r_wheel=r_wheel[1:1], n_units=n_units[1:1], r_friction=r_friction[1:1], mu_b_nominal=mu_b_nominal[1:1],
    mu_b_start=mu_b_start[1:1], T_disc_start=T_disc_start[1:1], start_speed=start_speed, tau_small=tau_small,
    suspension=suspension, creep=creep,
    curve=curve[1:2], resistance=resistance, pads=pads, discs=discs) "Leading motor bogie"
    annotation(Placement(transformation(extent={{-80, -20}, {-40, 20}})));
  Components.Bogie jacobs(
    redeclare block BogieContact = TrainContact, redeclare block BogieShaft = TrainShaft,
    redeclare block BogieRail = TrainRail,
    final n=2, final groups=2, behind=wheelset_position[3:4], m_wheelset=m_wheelset[3:4],
    m_unsprung=m_unsprung[3:4], m_frame=m_frame[2], I_frame=I_frame[2], wheelbase=wheelbase[2], J=J[2:3],
    r_wheel=r_wheel[2:3], n_units=n_units[2:3], r_friction=r_friction[2:3], mu_b_nominal=mu_b_nominal[2:3],
    mu_b_start=mu_b_start[2:3], T_disc_start=T_disc_start[2:3], start_speed=start_speed, tau_small=tau_small,
    suspension=suspension, creep=creep,
    curve=curve[3:4], resistance=resistance, pads=pads, discs=discs) "Jacobs bogie"
    annotation(Placement(transformation(extent={{-20, -20}, {20, 20}})));
  Components.Bogie trailing(
    redeclare block BogieContact = TrainContact, redeclare block BogieShaft = TrainShaft,
    redeclare block BogieRail = TrainRail,
    final n=2, final groups=1, behind=wheelset_position[5:6], m_wheelset=m_wheelset[5:6],
    m_unsprung=m_unsprung[5:6], m_frame=m_frame[3], I_frame=I_frame[3], wheelbase=wheelbase[3], J=J[4:4],
    r_wheel=r_wheel[4:4], n_units=n_units[4:4], r_friction=r_friction[4:4], mu_b_nominal=mu_b_nominal[4:4],
    mu_b_start=mu_b_start[4:4], T_disc_start=T_disc_start[4:4], start_speed=start_speed, tau_small=tau_small,
    suspension=suspension, creep=creep,
    curve=curve[5:6], resistance=resistance, pads=pads, discs=discs) "Trailing motor bogie"
    annotation(Placement(transformation(extent={{40, -20}, {80, 20}})));
equation
  connect(leading.pivot, body.pivot) annotation(
    Line(points={{-60, 22}, {-60, 30}, {0, 30}, {0, 38}}, color={0, 0, 127}));
  connect(jacobs.pivot, body.pivot) annotation(Line(points={{0, 22}, {0, 38}}, color={0, 0, 127}));
  connect(trailing.pivot, body.pivot) annotation(
    Line(points={{60, 22}, {60, 30}, {0, 30}, {0, 38}}, color={0, 0, 127}));
  body.standstill = standstill;
  body.track_force = track_force;
  v = {body.v};
  a = {body.a};
  m_body = {body.m};
  wheelset[1:2] = leading.wheelset;
  group[1:1] = leading.group;
  leading.mu0 = mu0[1:2];
  leading.pad_force = pad_force[1:1];
  leading.standstill = standstill;
  wheelset[3:4] = jacobs.wheelset;
  group[2:3] = jacobs.group;
  jacobs.mu0 = mu0[3:4];
  jacobs.pad_force = pad_force[2:3];
  jacobs.standstill = standstill;
  wheelset[5:6] = trailing.wheelset;
  group[4:4] = trailing.group;
  trailing.mu0 = mu0[5:6];
  trailing.pad_force = pad_force[4:4];
  trailing.standstill = standstill;
  totals.capacity = leading.totals.capacity + jacobs.totals.capacity + trailing.totals.capacity;
  totals.contact_power = leading.totals.contact_power + jacobs.totals.contact_power + trailing.totals.contact_power;
  totals.pad_power = leading.totals.pad_power + jacobs.totals.pad_power + trailing.totals.pad_power;
  totals.damper_power = leading.totals.damper_power + jacobs.totals.damper_power + trailing.totals.damper_power;
  totals.resistance_power = body.resistance_power + leading.totals.resistance_power + jacobs.totals.resistance_power
    + trailing.totals.resistance_power;
  totals.kinetic_energy = body.kinetic_energy + leading.totals.kinetic_energy + jacobs.totals.kinetic_energy
    + trailing.totals.kinetic_energy;
  coupler_power = 0;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-90, 40}, {-2, -40}}, lineColor={0, 0, 127}),
        Rectangle(extent={{2, 40}, {90, -40}}, lineColor={0, 0, 127}),
        Ellipse(extent={{-87, -43}, {-63, -67}}, lineColor={0, 0, 127}),
        Ellipse(extent={{-62, -43}, {-38, -67}}, lineColor={0, 0, 127}),
        Ellipse(extent={{-24, -43}, {0, -67}}, lineColor={0, 0, 127}),
        Ellipse(extent={{0, -43}, {24, -67}}, lineColor={0, 0, 127}),
        Ellipse(extent={{38, -43}, {62, -67}}, lineColor={0, 0, 127}),
        Ellipse(extent={{63, -43}, {87, -67}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The plant of Schwarz, Posielek and Goetjes (see References), equations (1) to (6): speed, angular velocity of four
groups, pad friction of four groups and, for the deflections of six primary suspensions, bounce and pitch of three
frames with their rates. Further states are disc temperatures, cylinder pressures, distance, air and four energies. It
is three <a href=\"modelica://RailBraking.Components.Bogie\">Bogies</a> under one <a
href=\"modelica://RailBraking.Components.CarBody\">CarBody</a>: the pattern for trains whose bogies differ.
</p>
<h4>Limitations</h4>
<p>
Those of <a href=\"modelica://RailBraking.Vehicles.PartialTrain\">PartialTrain</a>. The bodies are
joined rigidly: the force between them is not computed.
</p>
</html>"));
end PartialTwoPartTrain;
