within RailBraking.Components;
model GroupBrake "Brake units of one group, from the pad force to the torque"
  extends Icons.Component;
  parameter Real n_units(final unit="1", start=2) "Number of brake units";
  parameter Types.Length r_friction(start=0.22) "Radius at which the pads rub";
  replaceable Friction.PadFriction pad constrainedby Interfaces.PartialPadFriction "Friction between pads and disc"
    annotation(Placement(transformation(extent={{-60, -20}, {-20, 20}})));
  Friction.Disc disc "Disc of one unit"
    annotation(Placement(transformation(extent={{20, -20}, {60, 20}})));
  Interfaces.RealInput pad_force(final unit="N") "Normal force of both pads of one unit"
    annotation(Placement(transformation(extent={{-120, 57}, {-100, 77}})));
  Interfaces.RealInput w(final unit="rad/s") "Angular velocity of the disc"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealInput speed(final unit="m/s") "Speed of the vehicle, which cools"
    annotation(Placement(transformation(extent={{-120, -77}, {-100, -57}})));
  Interfaces.RealOutput torque(final unit="N.m") "Torque that the units can exert together"
    annotation(Placement(transformation(extent={{100, 40}, {120, 60}})));
  Interfaces.RealOutput heat_flow(final unit="W") "Heat made by all units"
    annotation(Placement(transformation(extent={{100, -60}, {120, -40}})));
equation
  pad.pad_force = pad_force;
  pad.pad_speed = r_friction*w;
  pad.temperature = disc.temperature;
  torque = n_units*pad.mu*pad_force*r_friction;
  heat_flow = torque*w;
  disc.heat_flow = heat_flow/n_units;
  disc.speed = speed;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Ellipse(extent={{-60, 60}, {60, -60}}, lineColor={0, 0, 127}),
        Rectangle(extent={{-15, 90}, {15, 40}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>torque = n_units &mu; pad_force r_friction. Friction answers to the temperature of the bulk of the disc.</p>
<h4>Limitations</h4>
<p>
All units of a group are equal. The coefficients of <a
href=\"modelica://RailBraking.Friction.PadFriction\">PadFriction</a>
belong to a mean temperature of the disc; with the surface temperature they would have to be found anew.
</p>
</html>"));
end GroupBrake;
