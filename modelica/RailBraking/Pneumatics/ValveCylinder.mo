within RailBraking.Pneumatics;
block ValveCylinder "Cylinders that valves fill, hold and vent"
  extends Icons.Pneumatic;
  extends PartialValveCylinder;
equation
  dp_fill = p_max - p;
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
Filled from a supply of constant pressure <code>p_max</code>; see
<a href=\"modelica://RailBraking.Pneumatics.PartialValveCylinder\">PartialValveCylinder</a>.
</p>
<h4>Limitations</h4>
<p>
Air consumption is counted, but does not lower the supply: see <a
href=\"modelica://RailBraking.Pneumatics.SuppliedCylinder\">SuppliedCylinder</a> for that.
</p>
</html>"));
end ValveCylinder;
