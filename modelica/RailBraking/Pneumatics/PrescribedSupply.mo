within RailBraking.Pneumatics;
model PrescribedSupply "Air of a given pressure, as much as is wanted"
  extends Icons.Pneumatic;
  Interfaces.RealInput pressure(final unit="Pa") "Pressure"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.AirPort port "Outlet" annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
equation
  port.p = pressure;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Ellipse(extent={{-50, 50}, {50, -50}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>Where what supplies the cylinders is given, and not how its vessels empty.</p>
<h4>Limitations</h4>
<p>It never runs out of air.</p>
</html>"));
end PrescribedSupply;
