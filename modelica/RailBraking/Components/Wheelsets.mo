within RailBraking.Components;
model Wheelsets "Wheelsets that turn as one, with their contacts"
  extends Icons.Component;
  replaceable block WheelsetsContact = Contact.WheelsetContact constrainedby Interfaces.PartialContact
    "Law of the contacts";
  replaceable block WheelsetsShaft = Components.RigidShaft constrainedby Interfaces.PartialShaft
    "Shafts between wheels and brake discs";
  parameter Integer n(min=1) = 1 "Number of wheelsets coupled to each other" annotation(Evaluate=true);
  parameter Types.Inertia J(start=209) "Inertia of all of them about their axles";
  parameter Types.Length r(start=0.38) "Rolling radius";
  parameter Types.Length r_rail = 0.30 "Radius of the rail head across the track";
  parameter Types.Curvature curvature_rail(min=0) = 0
    "Curvature of the rail along the track: zero, or that of a roller";
  parameter Types.Modulus E = 2.1e11 "Young's modulus of wheel and rail";
  parameter Types.Ratio nu = 0.28 "Poisson's ratio of wheel and rail";
  parameter Types.Velocity v_small = 0.1 "Speed below which slip is regularised";
  parameter Types.Ratio mu_bearing = 0.0018 "Friction coefficient of the axle bearings";
  parameter Types.Length r_bearing = 0.065 "Radius of the axle bearings";
  parameter Types.Length e_rolling = 0.0004 "Lever arm of the rolling resistance";
  parameter Types.Torque tau_small = 10 "Excess of the track's torque over the brake's that turns a locked group";
  parameter Types.AngularVelocity w_start(start=50) "Angular velocity at the start";
  final parameter Types.Ratio f_bearing = bearingFriction(mu_bearing, r_bearing, r) "Bearing resistance over load";
  input Data.CreepCurve curve[n] "Shape of the creep curve of each wheelset";
  Interfaces.RealInput v(final unit="m/s") "Speed along the track"
    annotation(Placement(transformation(extent={{-120, 70}, {-100, 90}})));
  Interfaces.RealInput load[n](each final unit="N") "Load of each wheelset"
    annotation(Placement(transformation(extent={{-120, 30}, {-100, 50}})));
  Interfaces.RealInput mu0[n](each final unit="1") "Maximum friction coefficient at each wheelset"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealInput brake_torque(final unit="N.m") "Maximum torque of the brake on the group"
    annotation(Placement(transformation(extent={{-120, -50}, {-100, -30}})));
  Interfaces.BooleanInput standstill "= true, if the train is at rest"
    annotation(Placement(transformation(extent={{-120, -90}, {-100, -70}})));
  Interfaces.RealOutput F[n](each final unit="N") "Braking force of the track on each wheelset"
    annotation(Placement(transformation(extent={{100, 73}, {120, 93}})));
  Interfaces.RealOutput torque(final unit="N.m") "Actual torque of the brake"
    annotation(Placement(transformation(extent={{100, 40}, {120, 60}})));
  Interfaces.RealOutput capacity(final unit="N") "Force with which the group can hold the train at rest"
    annotation(Placement(transformation(extent={{100, 7}, {120, 27}})));
  Interfaces.BooleanOutput locked(start=false, fixed=true) "= true, if the group is locked"
    annotation(Placement(transformation(extent={{100, -27}, {120, -7}})));
  Interfaces.RealOutput contact_power(final unit="W") "Heat generated in the contacts"
    annotation(Placement(transformation(extent={{100, -60}, {120, -40}})));
  Interfaces.RealOutput resistance_power(final unit="W") "Power of bearing and rolling resistance"
    annotation(Placement(transformation(extent={{100, -93}, {120, -73}})));
  Interfaces.RotationalFlange shaft "To a drive or an electrodynamic brake; may be left open"
    annotation(Placement(transformation(extent={{-10, 100}, {10, 120}})));
  Types.AngularVelocity w(start=w_start, fixed=true, nominal=1) "Angular velocity of the brake discs";
  WheelsetsShaft torsion(final n=n, final J_total=J, final w_start=w_start) "Shafts between wheels and brake discs"
    annotation(Placement(transformation(extent={{-20, 40}, {20, 80}})));
  WheelsetsContact contact[n](
    each r=r, each r_rail=r_rail, each curvature_rail=curvature_rail, each E=E, each nu=nu,
    curve=curve, each v_small=v_small) "Contacts of each wheelset"
    annotation(Placement(transformation(extent={{-20, -20}, {20, 20}})));
protected
  Types.Torque tau_track "Torque of track and shaft, forward";
  Types.Torque tau_resistance "Torque of bearing and rolling resistance";
equation
  for i in 1:n loop
    contact[i].v = v;
    contact[i].w = torsion.w_wheel;
    contact[i].load = load[i];
    contact[i].mu0 = mu0[i];
    F[i] = contact[i].F;
  end for;
  shaft.w = w;
  torsion.w = w;
  torsion.tau_wheel = r*sum(F);
  tau_track = torsion.tau + shaft.tau;
  tau_resistance = (r*f_bearing + e_rolling)*sum(load);
  // A level, not an edge: a group that is released and braked again at once must not reach reverse rotation.
  locked = standstill or (if pre(locked) then tau_track - brake_torque - tau_resistance <= tau_small
    else w <= 0 and tau_track - brake_torque - tau_resistance < 0);
  torsion.J_braked*der(w) = if locked then 0 else tau_track - brake_torque - tau_resistance;
  when locked then
    reinit(w, 0);
  end when;
  torque = if locked then tau_track else brake_torque;
  capacity = min((brake_torque + tau_resistance)/r, mu0*load);
  contact_power = sum(contact.heat_flow);
  resistance_power = tau_resistance*w + torsion.loss;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Ellipse(extent={{-70, 70}, {70, -70}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
One wheelset, or several wheelsets coupled by a drive shaft. A brake never reverses the rotation: if
the angular velocity reaches zero while the brake is stronger than the track, the group is
<code>locked</code>, and its angular velocity is exactly zero until the torque of the track exceeds
that of brake and resistance by <code>tau_small</code>.
</p>
<h4>Limitations</h4>
<p>
Forward rotation only. At rest the maximum torque of the brake is that at the end
of sliding. At standstill the contacts transmit no force in this model; <code>capacity</code> is the
force that can hold the train.
</p>
</html>"));
end Wheelsets;
