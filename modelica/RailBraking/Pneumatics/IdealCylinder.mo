within RailBraking.Pneumatics;
block IdealCylinder "Cylinders that follow a pressure command with a small lag"
  extends Icons.Pneumatic;
  extends Interfaces.PartialCylinder(command(final unit="Pa"));
  parameter Types.Time T = 0.02 "Time constant";
protected
  Types.Pressure p(start=p_start, fixed=true) "Pressure in the cylinders";
  Types.PressureRate rate "Rate of the pressure";
equation
  rate = (noEvent(min(max(command, 0), p_max)) - p)/T;
  der(p) = rate;
  pressure = p;
  air_flow = V/p_free*noEvent(max(rate, 0));
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-70, 40}, {70, -40}}, lineColor={0, 0, 127}),
        Line(points={{-10, 40}, {-10, -40}}, color={0, 0, 127}),
        Line(points={{-10, 0}, {90, 0}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The command is limited to the range from zero to <code>p_max</code>. The pressure follows a step
with the time constant <code>T</code>, 20 ms by default, which a proportional pressure control next
to the cylinder can achieve and which is fast in comparison with the dynamics of the vehicle.
</p>
<h4>Limitations</h4>
<p>
Valves in service cannot do this at the flow of a brake cylinder. The limits have sharp corners in
the command, not in the state, so that they cause no events while the command is constant.
</p>
</html>"));
end IdealCylinder;
