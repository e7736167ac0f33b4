within RailBraking.Pneumatics;
model PrescribedSupply "Unlimited supply of air at a given pressure"
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
<p>For a given supply pressure of the cylinders, without a model of its reservoirs.</p>
<h4>Limitations</h4>
<p>It never runs out of air.</p>
</html>"));
end PrescribedSupply;
