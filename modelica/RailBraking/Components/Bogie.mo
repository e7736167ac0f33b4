within RailBraking.Components;
model Bogie "Bogie of two axles or more, braked"
  extends Icons.Component;
  replaceable block BogieContact = Contact.WheelsetContact constrainedby Interfaces.PartialContact
    "Law of the contacts";
  replaceable block BogieShaft = Components.RigidShaft constrainedby Interfaces.PartialShaft
    "Shafts between wheels and brake discs";
  replaceable block BogieRail = Tracks.EvenRail constrainedby Interfaces.PartialRail "Height of the rail";
  replaceable block BogiePad = Friction.PadFriction constrainedby Interfaces.PartialPadFriction "Law of the pads";
  parameter Integer n(min=2) = 2 "Number of wheelsets" annotation(Evaluate=true);
  parameter Integer groups(min=1) = n
    "Number of groups of coupled wheelsets, equally large: n for none coupled, 1 for all"
    annotation(Evaluate=true);
  parameter Types.Mass m_wheelset[n](each min=1e-3, each start=14000)
    "Mass that each wheelset carries on the rail, including its own";
  parameter Types.Mass m_unsprung[n](each min=0, each start=1500) "Mass of each wheelset alone";
  parameter Types.Mass m_frame(min=1e-3, start=3500) "Mass of the frame";
  parameter Types.Inertia I_frame(min=1e-3, start=2200) "Pitch inertia of the frame";
  parameter Types.Length wheelbase(min=1e-3, start=2.2) "Distance of the first and the last wheelset";
  parameter Types.Length behind[n] = fill(0, n) "Distance of each wheelset behind the leading one of the train";
  parameter Types.Inertia J[groups](each min=1e-3, each start=110) "Inertia of each group about its axles";
  parameter Types.Length r_wheel[groups](each min=1e-3, each start=0.42) "Rolling radius of each group";
  parameter Types.Ratio n_units[groups](each min=0, each start=2) "Number of brake units of each group";
  parameter Types.Length r_friction[groups](each min=1e-3, each start=0.24) "Friction radius of the pads";
  parameter Types.Ratio mu_b_nominal[groups] = fill(0.35, groups)
    "Pad friction at nominal speed, pressure and temperature";
  parameter Types.Ratio mu_b_start[groups] = fill(0.35, groups) "Pad friction at the start";
  parameter Types.Temperature T_disc_start[groups] = fill(313.15, groups) "Temperature of the discs at the start";
  parameter Types.Velocity start_speed(min=0, start=22) "Speed at the start";
  parameter Types.Torque tau_small(min=1e-3) = 10
    "Excess of the track's torque over the brake's that turns a locked group";
  parameter Data.Suspension suspension "Frame and primary suspension";
  parameter Data.Creep creep "Contact";
  parameter Data.Resistance resistance "Bearings and rolling";
  parameter Data.Pad pads "Pads";
  parameter Data.Disc discs "Discs";
  input Data.CreepCurve curve[n] = {
    Data.CreepCurve(k_A=creep.k_A, k_S=creep.k_S, A=creep.A, B=creep.B) for i in 1:n}
    "Shape of the creep curve of each wheelset";
  Interfaces.TranslationalFlange pivot "Traction rod, to the body of a car"
    annotation(Placement(transformation(extent={{-10, 100}, {10, 120}})));
  Interfaces.RotationalFlange shaft[groups] "To drives or electrodynamic brakes; may be left open"
    annotation(Placement(transformation(extent={{-10, -120}, {10, -100}})));
  Interfaces.RealInput mu0[n](each final unit="1")
    "Maximum friction coefficient of the rail at each wheelset"
    annotation(Placement(transformation(extent={{-120, 53}, {-100, 73}})));
  Interfaces.RealInput pad_force[groups](each final unit="N")
    "Normal force of both pads of one unit"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.BooleanInput standstill
    "= true, if the train is at rest"
    annotation(Placement(transformation(extent={{-120, -73}, {-100, -53}})));
  Interfaces.WheelsetOutput wheelset[n] "Signals of each wheelset"
    annotation(Placement(transformation(extent={{100, 53}, {120, 73}})));
  Interfaces.GroupOutput group[groups] "Signals of each group"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  Interfaces.TotalsOutput totals "Sums over the wheelsets"
    annotation(Placement(transformation(extent={{100, -73}, {120, -53}})));
  Components.Axle axle[groups](
    redeclare block AxleContact = BogieContact, redeclare block AxleShaft = BogieShaft,
    redeclare block AxlePad = BogiePad,
    each n=size_of_group, J=J, r_wheel=r_wheel, n_units=n_units, r_friction=r_friction, mu_b_nominal=mu_b_nominal,
    mu_b_start=mu_b_start, T_disc_start=T_disc_start, each start_speed=start_speed,
    each tau_small=tau_small, each creep=creep,
    curve={{curve[size_of_group*(g - 1) + i] for i in 1:size_of_group} for g in 1:groups},
    each resistance=resistance, each pads=pads, each discs=discs) "Wheelsets with their brakes"
    annotation(Placement(transformation(extent={{-60, -60}, {-20, -20}})));
  Components.BogieFrame frame(
    final n=n, m_wheelset={m_wheelset[j] for j in 1:n}, m_unsprung={m_unsprung[j] for j in 1:n}, m_frame=m_frame,
    I_frame=I_frame, wheelbase=wheelbase,
    h_frame=suspension.h_frame, h_rod=suspension.h_rod, k=suspension.k, c=suspension.c,
    r_wheel=sum(r_wheel)/groups) "Frame on its primary suspension"
    annotation(Placement(transformation(extent={{-60, 20}, {-20, 60}})));
  BogieRail rail(final n=n, behind=behind) "Rail under the wheelsets"
    annotation(Placement(transformation(extent={{20, -60}, {60, -20}})));
  final parameter Integer size_of_group = div(n, groups) "Wheelsets of a group" annotation(Evaluate=true);
equation
  for g in 1:groups loop
    connect(axle[g].box, pivot) annotation(Line(points={{-40, -18}, {-40, 10}, {0, 10}, {0, 110}}, color={0, 0, 127}));
    connect(axle[g].shaft, shaft[g])
      annotation(Line(points={{-40, -62}, {-40, -80}, {0, -80}, {0, -110}}, color={0, 0, 127}));
    connect(pad_force[g], axle[g].pad_force);
    connect(axle[g].group, group[g]);
    connect(standstill, axle[g].standstill);
    for i in 1:size_of_group loop
      connect(mu0[size_of_group*(g - 1) + i], axle[g].mu0[i]);
      connect(frame.load[size_of_group*(g - 1) + i], axle[g].load[i]);
      wheelset[size_of_group*(g - 1) + i].F = axle[g].F[i];
    end for;
  end for;
  frame.a = der(pivot.v);
  rail.v = pivot.v;
  connect(rail.height, frame.rail_height)
    annotation(Line(points={{62, -28}, {84, -28}, {84, 4}, {-52, 4}, {-52, 18}}, color={0, 0, 127}));
  connect(rail.rate, frame.rail_rate)
    annotation(Line(points={{62, -40}, {80, -40}, {80, 0}, {-40, 0}, {-40, 18}}, color={0, 0, 127}));
  connect(rail.acceleration, frame.rail_acceleration)
    annotation(Line(points={{62, -52}, {76, -52}, {76, -4}, {-28, -4}, {-28, 18}}, color={0, 0, 127}));
  frame.F = pivot.f;
  frame.torque = sum(group.brake_torque);
  wheelset.load = frame.load;
  wheelset.deflection = frame.dz;
  totals.capacity = sum(axle.totals.capacity);
  totals.contact_power = sum(axle.totals.contact_power);
  totals.pad_power = sum(axle.totals.pad_power);
  totals.damper_power = frame.damper_power;
  totals.resistance_power = sum(axle.totals.resistance_power);
  totals.kinetic_energy = sum(axle.totals.kinetic_energy);
initial equation
  assert(n >= 2, "Bogie: n must be 2 or more; one wheelset does not hold the pitch of its frame.");
  assert(size_of_group*groups == n, "Bogie: all groups must have the same number of the n wheelsets.");
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-85, 10}, {85, 10}}, color={0, 0, 127}),
        Ellipse(extent={{-90, 0}, {-30, -60}}, lineColor={0, 0, 127}),
        Ellipse(extent={{30, 0}, {90, -60}}, lineColor={0, 0, 127}),
        Line(points={{0, 10}, {0, 100}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
A <a href=\"modelica://RailBraking.Components.BogieFrame\">BogieFrame</a> on its wheelsets, each an <a
href=\"modelica://RailBraking.Components.Axle\">Axle</a> or coupled to others by shafts. Connect <code>pivot</code>
with <a href=\"modelica://RailBraking.Components.CarBody\">CarBody</a>: the force on the body is that of all
wheelsets. A Jacobs bogie pulls at the body to which its pivot is connected.
</p>
<h4>Limitations</h4>
<p>
Those of its components. Its masses are counted in the car body along the track. The torque of
drives that are mounted on the frame does not pitch it.
</p>
</html>"));
end Bogie;
