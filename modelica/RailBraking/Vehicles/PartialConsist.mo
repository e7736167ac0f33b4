within RailBraking.Vehicles;
partial block PartialConsist "Train of equal cars, without the supply of the brake cylinders"
  extends Icons.Vehicle;
  extends PartialUniformTrain(
    final bogies=cars*bogies_per_car, final groups=cars*groups_of_car, final wheelsets=cars*wheelsets_of_car,
    wheelset_position=wheelsetPositions(
      cars, bogies_per_car, axles_per_bogie, car_length, pivots, bogie_wheelbase),
    wheelbase={bogie_wheelbase for i in 1:bogies});
  replaceable block TrainContact = Contact.WheelsetContact constrainedby Interfaces.PartialContact
    "Law of the contacts";
  replaceable block TrainShaft = Components.RigidShaft constrainedby Interfaces.PartialShaft
    "Shafts between wheels and brake discs";
  replaceable block TrainRail = Tracks.EvenRail constrainedby Interfaces.PartialRail "Height of the rail";
  replaceable block TrainPad = Friction.PadFriction constrainedby Interfaces.PartialPadFriction "Law of the pads";
  parameter Integer bogies_per_car(min=1) = 2 "Number of bogies of a car"
    annotation(Evaluate=true, Dialog(group="Formation"));
  parameter Integer axles_per_bogie(min=2) = 2 "Number of wheelsets of a bogie"
    annotation(Evaluate=true, Dialog(group="Formation"));
  parameter Integer groups_per_bogie(min=1) = axles_per_bogie "Number of groups of a bogie that turn as one"
    annotation(Evaluate=true, Dialog(group="Formation"));
  parameter Types.Length car_length(min=1e-3) = 20 "Length over couplers; affects positions, not dynamics"
    annotation(Dialog(group="Formation"));
  parameter Types.Length pivots(min=1e-3) = 14 "Distance of the pivots; affects positions, not dynamics"
    annotation(Dialog(group="Formation"));
  parameter Types.Length bogie_wheelbase(min=1e-3) = 2.2 "Wheelbase of all bogies"
    annotation(Dialog(group="Formation"));
  parameter Types.Stiffness k_coupler(min=1) = 5e7 "Stiffness of a coupler" annotation(Dialog(group="Couplers"));
  parameter Types.Damping c_coupler(min=0) = 5e5 "Damping of a coupler" annotation(Dialog(group="Couplers"));
  parameter Types.Length slack_coupler(min=0) = 0 "Slack of a coupler" annotation(Dialog(group="Couplers"));
  Interfaces.RealInput car_track_force[cars](each final unit="N", each start=0)
    "Force of gradient and curve on each car less its share of track_force by mass"
    annotation(Placement(transformation(extent={{-120, -100}, {-100, -80}})));
protected
  final parameter Integer wheelsets_of_car = bogies_per_car*axles_per_bogie "Wheelsets of a car"
    annotation(Evaluate=true);
  final parameter Integer groups_of_car = bogies_per_car*groups_per_bogie "Groups of a car" annotation(Evaluate=true);
  Car car[cars](
    redeclare block CarContact = TrainContact, redeclare block CarShaft = TrainShaft,
    redeclare block CarRail = TrainRail, redeclare block CarPad = TrainPad,
    each bogies=bogies_per_car, each axles=axles_per_bogie, each groups=groups_per_bogie,
    behind={{wheelset_position[wheelsets_of_car*(c - 1) + i] for i in 1:wheelsets_of_car} for c in 1:cars},
    m_wheelset={{m_wheelset[wheelsets_of_car*(c - 1) + i] for i in 1:wheelsets_of_car} for c in 1:cars},
    m_unsprung={{m_unsprung[wheelsets_of_car*(c - 1) + i] for i in 1:wheelsets_of_car} for c in 1:cars},
    m_frame={{m_frame[bogies_per_car*(c - 1) + i] for i in 1:bogies_per_car} for c in 1:cars},
    I_frame={{I_frame[bogies_per_car*(c - 1) + i] for i in 1:bogies_per_car} for c in 1:cars},
    wheelbase={{wheelbase[bogies_per_car*(c - 1) + i] for i in 1:bogies_per_car} for c in 1:cars},
    J={{J[groups_of_car*(c - 1) + i] for i in 1:groups_of_car} for c in 1:cars},
    r_wheel={{r_wheel[groups_of_car*(c - 1) + i] for i in 1:groups_of_car} for c in 1:cars},
    n_units={{n_units[groups_of_car*(c - 1) + i] for i in 1:groups_of_car} for c in 1:cars},
    r_friction={{r_friction[groups_of_car*(c - 1) + i] for i in 1:groups_of_car} for c in 1:cars},
    mu_b_nominal={{mu_b_nominal[groups_of_car*(c - 1) + i] for i in 1:groups_of_car} for c in 1:cars},
    mu_b_start={{mu_b_start[groups_of_car*(c - 1) + i] for i in 1:groups_of_car} for c in 1:cars},
    T_disc_start={{T_disc_start[groups_of_car*(c - 1) + i] for i in 1:groups_of_car} for c in 1:cars},
    each start_speed=start_speed, each tau_small=tau_small, each drag=drag, each suspension=suspension,
    each creep=creep,
    curve={{curve[wheelsets_of_car*(c - 1) + i] for i in 1:wheelsets_of_car} for c in 1:cars},
    each resistance=resistance, each pads=pads, each discs=discs) "Cars"
    annotation(Placement(transformation(extent={{-60, -20}, {-20, 20}})));
  Components.Coupler coupler[couplers](each k=k_coupler, each c=c_coupler, each slack=slack_coupler)
    "Couplers behind all cars but the last"
    annotation(Placement(transformation(extent={{20, -20}, {60, 20}})));
equation
  for c in 1:cars loop
    car[c].standstill = standstill;
    car[c].track_force = track_force*car[c].mass/m_train + car_track_force[c];
    v[c] = car[c].v;
    a[c] = car[c].a;
    m_body[c] = car[c].mass;
    for i in 1:wheelsets_of_car loop
      car[c].mu0[i] = mu0[wheelsets_of_car*(c - 1) + i];
      wheelset[wheelsets_of_car*(c - 1) + i] = car[c].wheelset[i];
    end for;
    for i in 1:groups_of_car loop
      group[groups_of_car*(c - 1) + i] = car[c].group[i];
      car[c].pad_force[i] = pad_force[groups_of_car*(c - 1) + i];
    end for;
  end for;
  for c in 1:couplers loop
    connect(car[c].rear, coupler[c].front) annotation(Line(points={{-18, 0}, {18, 0}}, color={0, 0, 127}));
    connect(coupler[c].rear, car[c + 1].front) annotation(
      Line(points={{62, 0}, {80, 0}, {80, 40}, {-80, 40}, {-80, 0}, {-62, 0}}, color={0, 0, 127}));
    coupler_force[c] = coupler[c].force;
  end for;
  totals.capacity = sum(car.totals.capacity);
  totals.contact_power = sum(car.totals.contact_power);
  totals.pad_power = sum(car.totals.pad_power);
  totals.damper_power = sum(car.totals.damper_power);
  totals.resistance_power = sum(car.totals.resistance_power);
  totals.kinetic_energy = sum(car.totals.kinetic_energy);
  coupler_power = sum(coupler.power);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-95, 30}, {-35, -30}}, lineColor={0, 0, 127}),
        Rectangle(extent={{-30, 30}, {30, -30}}, lineColor={0, 0, 127}),
        Rectangle(extent={{35, 30}, {95, -30}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Any number of <a href=\"modelica://RailBraking.Vehicles.Car\">Cars</a> with <a
href=\"modelica://RailBraking.Components.Coupler\">Couplers</a> between them; cars, wheelsets and groups count from
the front. Gradients and curves act on each car: <code>track_force</code> is the force on the train, of which each car
has its share by mass, and <code>car_track_force</code> the difference of each car to that share, where cars are on
different gradients. The sum of the differences is zero.
</p>
<h4>Limitations</h4>
<p>
Those of <a href=\"modelica://RailBraking.Vehicles.PartialTrain\">PartialTrain</a>. All cars have the same numbers of
bogies, wheelsets and groups, and all couplers are alike.
</p>
</html>"));
end PartialConsist;
