within RailBraking.Components;
model GroupBrake "Brake units of one group, from the pad force to the torque"
  parameter Real n_units(final unit="1", start=2) "Number of brake units";
  parameter Types.Length r_friction(start=0.22) "Radius at which the pads rub";
  replaceable Friction.PadFriction pad constrainedby Interfaces.PartialPadFriction "Friction between pads and disc";
  Friction.Disc disc "Disc of one unit";
  Interfaces.RealInput pad_force(final unit="N") "Normal force of both pads of one unit";
  Interfaces.RealInput w(final unit="rad/s") "Angular velocity of the disc";
  Interfaces.RealInput speed(final unit="m/s") "Speed of the vehicle, which cools";
  Interfaces.RealOutput torque(final unit="N.m") "Torque that the units can exert together";
  Interfaces.RealOutput heat_flow(final unit="W") "Heat made by all units";
equation
  pad.pad_force = pad_force;
  pad.pad_speed = r_friction*w;
  pad.temperature = disc.temperature;
  torque = n_units*pad.mu*pad_force*r_friction;
  heat_flow = torque*w;
  disc.heat_flow = heat_flow/n_units;
  disc.speed = speed;
  annotation (Documentation(info="<html>
<p>torque = n_units &mu; pad_force r_friction. Friction answers to the temperature of the bulk of the disc.</p>
<h4>Limitations</h4>
<p>
All units of a group are equal. The coefficients of <a
href=\"modelica://RailBraking.Friction.PadFriction\">PadFriction</a>
belong to a mean temperature of the disc; with the surface temperature they would have to be found anew.
</p>
</html>"));
end GroupBrake;
