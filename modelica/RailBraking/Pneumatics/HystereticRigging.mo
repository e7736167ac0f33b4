within RailBraking.Pneumatics;
block HystereticRigging "Piston, levers and return spring whose friction opposes the motion"
  extends Icons.Pneumatic;
  extends Interfaces.PartialRigging;
  parameter Types.Ratio hysteresis(min=0, max=0.5) = 0.06 "Half width of the hysteresis over the mean force";
  parameter Types.Pressure p_reverse = 1e4 "Change of pressure in which friction reverses";
  parameter Types.Pressure p_seal(min=0) = 0 "Pressure that overcomes the preload of the piston's seal";
protected
  final parameter Types.PressureRate rate_small = 10 "Rounding of the magnitude of the rate";
  Types.PressureRate rate "Rate of the pressure";
  Types.Ratio direction(start=0, fixed=true, nominal=1) "Friction over its limit, 1 when applying, -1 when releasing";
equation
  rate = der(pressure);
  p_reverse*der(direction) = rate - (sqrt(rate^2 + rate_small^2) - rate_small)*direction;
  pad_force =
    padForce(pressure - p_seal*direction, A_piston, i_rigging, eta_rigging, F_spring)*(1 - hysteresis*direction);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-60, 60}, {-60, -60}}, color={0, 0, 127}),
        Line(points={{-60, 0}, {60, 0}}, color={0, 0, 127}),
        Line(points={{60, 60}, {60, -60}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Dahl's friction: after a reversal the pad force is nearly constant until the pressure has changed by
about <code>p_reverse</code>, independent of the rate of change. Calipers have 5 % to 8 % on either
side of the mean: friction of the levers and the part of the seal's friction that is proportional to the pressure. A
load cell between the pads measures both together over the pressure (doi:10.1177/1687814015616086).
</p>
<p>
The seal is also squeezed when it is mounted. The friction of this preload, <code>A_piston*p_seal</code>, is the same
at any pressure: it delays the contact of the pads when the brake is applied, keeps them on the disc for longer when it
is released, and is the larger part of the hysteresis at the low pressures of a slippery rail. Preload and a part
proportional to the pressure are the usual model of cylinders (Simscape Fluids, Cylinder Friction).
</p>
<h4>Limitations</h4>
<p>
The hysteresis depends on the pressure alone. Once the pads touch the disc, the piston hardly moves: the fall of
friction with speed (Stribeck) is not modelled, nor are wear of the levers and stiction after a long rest.
</p>
</html>"));
end HystereticRigging;
