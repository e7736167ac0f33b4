within RailBraking.Pneumatics;
block PrescribedPressure "Cylinders whose pressure is the command"
  extends Icons.Pneumatic;
  extends Interfaces.PartialCylinder;
equation
  pressure = command;
  air_flow = 0;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-70, 40}, {70, -40}}, lineColor={0, 0, 127}),
        Line(points={{-10, 40}, {-10, -40}}, color={0, 0, 127}),
        Line(points={{-10, 0}, {90, 0}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>For validation, and for measured pressures.</p>
<h4>Limitations</h4>
<p>No lag, no bound, no air counted; <code>p_max</code>, <code>V</code> and <code>p_start</code> have no effect.</p>
</html>"));
end PrescribedPressure;
