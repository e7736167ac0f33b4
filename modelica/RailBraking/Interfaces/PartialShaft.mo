within RailBraking.Interfaces;
partial block PartialShaft "Shafts between the wheels and the brake discs of coupled wheelsets"
  extends Icons.Component;
  parameter Integer n(min=1) = 1 "Number of wheelsets coupled to each other";
  parameter Types.Inertia J_total(start=209) "Inertia of all of them about their axles";
  parameter Types.AngularVelocity w_start(start=50) "Angular velocity at the start";
  RealInput w(final unit="rad/s") "Angular velocity of the brake discs"
    annotation(Placement(transformation(extent={{-120, 30}, {-100, 50}})));
  RealInput tau_wheel(final unit="N.m") "Torque of the track on the wheels, forward"
    annotation(Placement(transformation(extent={{-120, -50}, {-100, -30}})));
  RealOutput J_braked(final unit="kg.m2") "Inertia that turns with the brake discs"
    annotation(Placement(transformation(extent={{100, 70}, {120, 90}})));
  RealOutput w_wheel(final unit="rad/s") "Angular velocity of the wheels"
    annotation(Placement(transformation(extent={{100, 30}, {120, 50}})));
  RealOutput tau(final unit="N.m") "Torque on the brake discs, forward"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  RealOutput energy(final unit="J") "Energy of rotation and of the twist"
    annotation(Placement(transformation(extent={{100, -50}, {120, -30}})));
  RealOutput loss(final unit="W") "Power lost in the twist"
    annotation(Placement(transformation(extent={{100, -90}, {120, -70}})));
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>Speed sensors and brakes are on the side of the brake discs.</p>
</html>"));
end PartialShaft;
