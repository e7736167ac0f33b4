within RailBraking.Components;
model Axle "Wheelset with its brake, or several wheelsets that turn as one"
  extends Icons.Component;
  replaceable block AxleContact = Contact.WheelsetContact constrainedby Interfaces.PartialContact
    "Law of the contacts";
  replaceable block AxleShaft = Components.RigidShaft constrainedby Interfaces.PartialShaft
    "Shafts between wheels and brake discs";
  replaceable block AxlePad = Friction.PadFriction constrainedby Interfaces.PartialPadFriction "Law of the pads";
  parameter Integer n(min=1) = 1 "Number of wheelsets coupled to each other" annotation(Evaluate=true);
  parameter Types.Inertia J(min=1e-3, start=110) "Inertia of all of them about their axles";
  parameter Types.Length r_wheel(min=1e-3, start=0.42) "Rolling radius";
  parameter Types.Ratio n_units(min=0, start=2) "Number of brake units";
  parameter Types.Length r_friction(min=1e-3, start=0.24) "Friction radius of the pads";
  parameter Types.Ratio mu_b_nominal = 0.35 "Pad friction at nominal speed, pressure and temperature";
  parameter Types.Ratio mu_b_start = 0.35 "Pad friction at the start";
  parameter Types.Temperature T_disc_start = 313.15 "Temperature of the discs at the start";
  parameter Types.Velocity start_speed(min=0, start=22) "Speed at the start";
  parameter Types.Torque tau_small(min=1e-3) = 10
    "Excess of the track's torque over the brake's that turns a locked axle";
  parameter Data.Creep creep "Contact";
  parameter Data.Resistance resistance "Bearings and rolling";
  parameter Data.Pad pads "Pads";
  parameter Data.Disc discs "Discs";
  input Data.CreepCurve curve[n] = {
    Data.CreepCurve(k_A=creep.k_A, k_S=creep.k_S, A=creep.A, B=creep.B) for i in 1:n}
    "Shape of the creep curve of each wheelset";
  Interfaces.TranslationalFlange box "Axle boxes, to the bogie frame"
    annotation(Placement(transformation(extent={{-10, 100}, {10, 120}})));
  Interfaces.RotationalFlange shaft "To a drive or an electrodynamic brake; may be left open"
    annotation(Placement(transformation(extent={{-10, -120}, {10, -100}})));
  Interfaces.RealInput load[n](each final unit="N")
    "Load of each wheelset on the rail"
    annotation(Placement(transformation(extent={{-120, 61}, {-100, 81}})));
  Interfaces.RealInput mu0[n](each final unit="1")
    "Maximum friction coefficient of the rail at each wheelset"
    annotation(Placement(transformation(extent={{-120, 14}, {-100, 34}})));
  Interfaces.RealInput pad_force(final unit="N")
    "Normal force of both pads of one unit"
    annotation(Placement(transformation(extent={{-120, -34}, {-100, -14}})));
  Interfaces.BooleanInput standstill
    "= true, if the train is at rest"
    annotation(Placement(transformation(extent={{-120, -81}, {-100, -61}})));
  Interfaces.RealOutput F[n](each final unit="N") "Braking force of the track on each wheelset"
    annotation(Placement(transformation(extent={{100, 53}, {120, 73}})));
  Interfaces.GroupOutput group "Signals of the wheelsets as one"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  Interfaces.TotalsOutput totals "Sums over the wheelsets"
    annotation(Placement(transformation(extent={{100, -73}, {120, -53}})));
  Components.Wheelsets wheels(
    redeclare block WheelsetsContact = AxleContact, redeclare block WheelsetsShaft = AxleShaft,
    final n=n, J=J, r=r_wheel, r_rail=creep.r_rail,
    curvature_rail=creep.curvature_rail, E=creep.E, nu=creep.nu, curve=curve, v_small=creep.v_small,
    mu_bearing=resistance.mu_bearing, r_bearing=resistance.r_bearing,
    e_rolling=resistance.e_rolling, tau_small=tau_small, w_start=start_speed/r_wheel) "Wheelsets on the rails"
    annotation(Placement(transformation(extent={{20, -20}, {60, 20}})));
  Components.GroupBrake brake(
    n_units=n_units, r_friction=r_friction,
    redeclare AxlePad pad(
      mu_nominal=mu_b_nominal, mu_start=mu_b_start, speed_effect=pads.speed_effect,
      pad_speed_nominal=pads.pad_speed_nominal, temperature_effect=pads.temperature_effect,
      temperature_nominal=pads.temperature_nominal, temperature_range=pads.temperature_range,
      force_effect=pads.force_effect, pad_force_nominal=pads.pad_force_nominal, E_settle=pads.E_settle,
      T_settle=pads.T_settle, F_release=pads.F_release),
    disc(
      m=discs.m, m_surface=discs.m_surface, c_p=discs.c_p, G=discs.G, G_rest=discs.G_rest, G_speed=discs.G_speed,
      pad_share=discs.pad_share, T_ambient=discs.T_ambient, T_start=T_disc_start)) "Brake units"
    annotation(Placement(transformation(extent={{-60, -20}, {-20, 20}})));
equation
  wheels.v = box.v;
  box.f = sum(wheels.F);
  connect(shaft, wheels.shaft) annotation(Line(points={{0, -110}, {0, 30}, {40, 30}, {40, 22}}, color={0, 0, 127}));
  connect(load, wheels.load);
  connect(mu0, wheels.mu0);
  connect(standstill, wheels.standstill);
  connect(brake.torque, wheels.brake_torque)
    annotation(Line(points={{-18, 10}, {0, 10}, {0, -8}, {18, -8}}, color={0, 0, 127}));
  connect(pad_force, brake.pad_force);
  brake.w = wheels.w;
  brake.speed = box.v;
  F = wheels.F;
  group.w = wheels.w;
  group.slip = wheels.contact[1].slip;
  group.adhesion = sum(wheels.F)/sum(load);
  group.pad_friction = brake.pad.mu;
  group.disc_temperature = brake.disc.temperature;
  group.disc_surface_temperature = brake.disc.temperature_surface;
  group.brake_torque = wheels.torque;
  group.locked = wheels.locked;
  totals.capacity = wheels.capacity;
  totals.contact_power = wheels.contact_power;
  totals.pad_power = brake.heat_flow;
  totals.damper_power = 0;
  totals.resistance_power = wheels.resistance_power;
  totals.kinetic_energy = wheels.torsion.energy;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Ellipse(extent={{-70, 70}, {70, -70}}, lineColor={0, 0, 127}),
        Ellipse(extent={{-40, 40}, {40, -40}}, lineColor={0, 0, 127}),
        Rectangle(extent={{-15, 60}, {15, 30}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
<a href=\"modelica://RailBraking.Components.Wheelsets\">Wheelsets</a> on the rails and their <a
href=\"modelica://RailBraking.Components.GroupBrake\">GroupBrake</a>. Cylinders and riggings are not
included: a valve that several axles share is one cylinder whose pressure acts on the riggings of
all of them. J dw/dt = r_wheel
&Sigma;F + shaft.tau - brake - resistance while the wheelsets turn.
</p>
<h4>Limitations</h4>
<p>
Those of its components. The mass of the wheelset belongs to the car. All wheelsets of the axle have
the same radius, pad and disc.
</p>
</html>"));
end Axle;
