within RailBraking.Vehicles;
model Car "Car body on equal bogies"
  extends Icons.Vehicle;
  replaceable block CarContact = Contact.WheelsetContact constrainedby Interfaces.PartialContact
    "Law of the contacts";
  replaceable block CarShaft = Components.RigidShaft constrainedby Interfaces.PartialShaft
    "Shafts between wheels and brake discs";
  replaceable block CarRail = Tracks.EvenRail constrainedby Interfaces.PartialRail "Height of the rail";
  replaceable block CarPad = Friction.PadFriction constrainedby Interfaces.PartialPadFriction "Law of the pads";
  parameter Integer bogies(min=1) = 2 "Number of bogies" annotation(Evaluate=true);
  parameter Integer axles(min=2) = 2 "Number of wheelsets of a bogie" annotation(Evaluate=true);
  parameter Integer groups(min=1) = axles "Number of groups of a bogie that turn as one" annotation(Evaluate=true);
  parameter Types.Length behind[bogies*axles] = fill(0, bogies*axles)
    "Distance of each wheelset behind the leading one of the train";
  parameter Types.Mass m_wheelset[bogies*axles](each min=1e-3) = fill(12000, bogies*axles)
    "Mass that each wheelset carries on the rail, including its own";
  parameter Types.Mass m_unsprung[bogies*axles](each min=0) = fill(1500, bogies*axles) "Mass of each wheelset alone";
  parameter Types.Mass m_frame[bogies](each min=1e-3) = fill(3000, bogies) "Mass of each bogie frame";
  parameter Types.Inertia I_frame[bogies](each min=1e-3) = fill(2000, bogies) "Pitch inertia of each bogie frame";
  parameter Types.Length wheelbase[bogies](each min=1e-3) = fill(2.2, bogies)
    "Distance of the first and the last wheelset of each bogie";
  parameter Types.Inertia J[bogies*groups](each min=1e-3) = fill(110, bogies*groups)
    "Inertia of each group about its axles";
  parameter Types.Length r_wheel[bogies*groups](each min=1e-3) = fill(0.42, bogies*groups)
    "Rolling radius of each group";
  parameter Types.Ratio n_units[bogies*groups](each min=0) = fill(2, bogies*groups)
    "Number of brake units of each group";
  parameter Types.Length r_friction[bogies*groups](each min=1e-3) = fill(0.24, bogies*groups)
    "Friction radius of the pads";
  parameter Types.Ratio mu_b_nominal[bogies*groups] = fill(0.35, bogies*groups)
    "Pad friction at nominal speed, pressure and temperature";
  parameter Types.Ratio mu_b_start[bogies*groups] = fill(0.35, bogies*groups) "Pad friction at the start";
  parameter Types.Temperature T_disc_start[bogies*groups] = fill(313.15, bogies*groups)
    "Temperature of the discs at the start";
  parameter Types.Velocity start_speed(min=0) = 22 "Speed at the start";
  parameter Types.Torque tau_small(min=1e-3) = 10
    "Excess of the track's torque over the brake's that turns a locked group";
  parameter Data.Drag drag "Air";
  parameter Data.Suspension suspension "Frames and primary suspension";
  parameter Data.Creep creep "Contact";
  parameter Data.Resistance resistance "Bearings and rolling";
  parameter Data.Pad pads "Pads";
  parameter Data.Disc discs "Discs";
  input Data.CreepCurve curve[bogies*axles] = {
    Data.CreepCurve(k_A=creep.k_A, k_S=creep.k_S, A=creep.A, B=creep.B) for i in 1:bogies*axles}
    "Shape of the creep curve of each wheelset";
  Interfaces.TranslationalFlange front "Front end"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.TranslationalFlange rear "Rear end"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  Interfaces.TranslationalFlange pivot "Other brakes or supports of the car"
    annotation(Placement(transformation(extent={{-10, 100}, {10, 120}})));
  Interfaces.RotationalFlange shaft[bogies*groups] "To drives or electrodynamic brakes; may be left open"
    annotation(Placement(transformation(extent={{-10, -120}, {10, -100}})));
  Interfaces.RealInput mu0[bogies*axles](each final unit="1")
    "Maximum friction coefficient of the rail at each wheelset"
    annotation(Placement(transformation(extent={{-120, 61}, {-100, 81}})));
  Interfaces.RealInput pad_force[bogies*groups](each final unit="N")
    "Normal force of both pads of one unit"
    annotation(Placement(transformation(extent={{-120, 14}, {-100, 34}})));
  Interfaces.RealInput track_force(final unit="N")
    "Force of gradient and curve on this car, forward"
    annotation(Placement(transformation(extent={{-120, -34}, {-100, -14}})));
  Interfaces.BooleanInput standstill
    "= true, if the train is at rest"
    annotation(Placement(transformation(extent={{-120, -81}, {-100, -61}})));
  Interfaces.RealOutput v(final unit="m/s")
    "Speed"
    annotation(Placement(transformation(extent={{100, 86}, {110, 94}})));
  Interfaces.RealOutput a(final unit="m/s2")
    "Acceleration"
    annotation(Placement(transformation(extent={{100, 77}, {110, 85}})));
  Interfaces.RealOutput mass(final unit="kg")
    "Mass of the car and its bogies, without rotating masses"
    annotation(Placement(transformation(extent={{100, 68}, {110, 76}})));
  Interfaces.WheelsetOutput wheelset[bogies*axles] "Signals of each wheelset"
    annotation(Placement(transformation(extent={{100, 30}, {120, 50}})));
  Interfaces.GroupOutput group[bogies*groups] "Signals of each group"
    annotation(Placement(transformation(extent={{100, -40}, {120, -20}})));
  Interfaces.TotalsOutput totals "Sums over the car"
    annotation(Placement(transformation(extent={{100, -73}, {120, -53}})));
  Components.CarBody body(m=sum(m_wheelset), start_speed=start_speed, drag=drag) "Body"
    annotation(Placement(transformation(extent={{-60, 20}, {-20, 60}})));
  Components.Bogie bogie[bogies](
    redeclare block BogieContact = CarContact, redeclare block BogieShaft = CarShaft,
    redeclare block BogieRail = CarRail, redeclare block BogiePad = CarPad,
    each n=axles, each groups=groups, behind={{behind[axles*(b - 1) + i] for i in 1:axles} for b in 1:bogies},
    m_wheelset={{m_wheelset[axles*(b - 1) + i] for i in 1:axles} for b in 1:bogies},
    m_unsprung={{m_unsprung[axles*(b - 1) + i] for i in 1:axles} for b in 1:bogies}, m_frame=m_frame,
    I_frame=I_frame, wheelbase=wheelbase, J={{J[groups*(b - 1) + i] for i in 1:groups} for b in 1:bogies},
    r_wheel={{r_wheel[groups*(b - 1) + i] for i in 1:groups} for b in 1:bogies},
    n_units={{n_units[groups*(b - 1) + i] for i in 1:groups} for b in 1:bogies},
    r_friction={{r_friction[groups*(b - 1) + i] for i in 1:groups} for b in 1:bogies},
    mu_b_nominal={{mu_b_nominal[groups*(b - 1) + i] for i in 1:groups} for b in 1:bogies},
    mu_b_start={{mu_b_start[groups*(b - 1) + i] for i in 1:groups} for b in 1:bogies},
    T_disc_start={{T_disc_start[groups*(b - 1) + i] for i in 1:groups} for b in 1:bogies}, each start_speed=start_speed,
    each tau_small=tau_small, each suspension=suspension, each creep=creep,
    curve={{curve[axles*(b - 1) + i] for i in 1:axles} for b in 1:bogies}, each resistance=resistance,
    each pads=pads, each discs=discs) "Bogies"
    annotation(Placement(transformation(extent={{-60, -60}, {-20, -20}})));
equation
  connect(front, body.front) annotation(Line(points={{-110, 0}, {-80, 0}, {-80, 40}, {-62, 40}}, color={0, 0, 127}));
  connect(body.rear, rear) annotation(Line(points={{-18, 40}, {60, 40}, {60, 0}, {110, 0}}, color={0, 0, 127}));
  connect(pivot, body.pivot) annotation(
    Line(points={{0, 110}, {0, 10}, {-40, 10}, {-40, 18}}, color={0, 0, 127}));
  connect(track_force, body.track_force);
  connect(standstill, body.standstill);
  for b in 1:bogies loop
    connect(bogie[b].pivot, body.pivot) annotation(Line(points={{-40, -18}, {-40, 18}}, color={0, 0, 127}));
    connect(standstill, bogie[b].standstill);
    for i in 1:axles loop
      connect(mu0[axles*(b - 1) + i], bogie[b].mu0[i]);
      connect(bogie[b].wheelset[i], wheelset[axles*(b - 1) + i]);
    end for;
    for i in 1:groups loop
      connect(pad_force[groups*(b - 1) + i], bogie[b].pad_force[i]);
      connect(bogie[b].shaft[i], shaft[groups*(b - 1) + i]) annotation(
        Line(points={{-40, -62}, {-40, -80}, {0, -80}, {0, -110}}, color={0, 0, 127}));
      connect(bogie[b].group[i], group[groups*(b - 1) + i]);
    end for;
  end for;
  v = body.v;
  a = body.a;
  mass = body.m;
  totals.capacity = sum(bogie.totals.capacity);
  totals.contact_power = sum(bogie.totals.contact_power);
  totals.pad_power = sum(bogie.totals.pad_power);
  totals.damper_power = sum(bogie.totals.damper_power);
  totals.resistance_power = body.resistance_power + sum(bogie.totals.resistance_power);
  totals.kinetic_energy = body.kinetic_energy + sum(bogie.totals.kinetic_energy);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-90, 40}, {90, -30}}, lineColor={0, 0, 127}),
        Ellipse(extent={{-80, -35}, {-50, -65}}, lineColor={0, 0, 127}),
        Ellipse(extent={{-40, -35}, {-10, -65}}, lineColor={0, 0, 127}),
        Ellipse(extent={{10, -35}, {40, -65}}, lineColor={0, 0, 127}),
        Ellipse(extent={{50, -35}, {80, -65}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
A <a href=\"modelica://RailBraking.Components.CarBody\">CarBody</a> with its <a
href=\"modelica://RailBraking.Components.Bogie\">Bogies</a>. Wheelsets and groups count from the front. Cylinders
and riggings are the train's: a cylinder may be that of an axle, of a bogie or of a car.
</p>
<h4>Limitations</h4>
<p>
All bogies have the same numbers of wheelsets and groups; a car with others is a CarBody and Bogies of its own, as in
<a href=\"modelica://RailBraking.Vehicles.PartialTwoPartTrain\">PartialTwoPartTrain</a>.
</p>
</html>"));
end Car;
