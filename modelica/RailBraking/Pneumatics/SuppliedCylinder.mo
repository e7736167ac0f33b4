within RailBraking.Pneumatics;
model SuppliedCylinder "Cylinders that valves fill from an air port, hold and vent"
  extends Icons.Pneumatic;
  extends PartialValveCylinder;
  parameter Boolean relayed = false "= true, if the supply is a relay valve, which also vents"
    annotation(Evaluate=true);
  Interfaces.AirPort supply "Reservoir, or outlet of the distributor"
    annotation(Placement(transformation(extent={{-10, -120}, {10, -100}})));
equation
  dp_fill = noEvent(if relayed then min(supply.p, p_max) - p else max(min(supply.p, p_max) - p, 0));
  supply.q = air_flow;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-70, 40}, {70, -40}}, lineColor={0, 0, 127}),
        Line(points={{-10, 40}, {-10, -40}}, color={0, 0, 127}),
        Line(points={{-10, 0}, {90, 0}}, color={0, 0, 127}),
        Line(points={{0, -100}, {0, -40}}, color={0, 127, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Filled to at most <code>p_max</code> from a port whose pressure falls with the air consumption,
without backflow; with <code>relayed</code> also vented to its pressure while the fill valve is open. See
<a href=\"modelica://RailBraking.Pneumatics.PartialValveCylinder\">PartialValveCylinder</a>.
</p>
<h4>Limitations</h4>
<p>Without <code>relayed</code> a distributor cannot release the cylinders: command the vent valve.</p>
</html>"));
end SuppliedCylinder;
