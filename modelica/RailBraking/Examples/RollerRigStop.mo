within RailBraking.Examples;
model RollerRigStop "Wheelset on the roller, braked into a slide and released"
  FMUs.RollerRig rig(speed_start=30) "Rig"
    annotation(Placement(transformation(extent={{-20, -20}, {20, 20}})));
equation
  rig.mu0 = 0.06;
  rig.valve_command = if time < 1 then 0 elseif time < 3 then 1 else -1;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Polygon(points={{-40, 60}, {60, 0}, {-40, -60}}, lineColor={0, 0, 127}),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    experiment(StopTime=6, Tolerance=1e-7, Interval=0.01),
    Documentation(info="<html>
<p>The wheelset slides from about 1.5 s on, and turns with the roller again after the release.</p>
</html>"));
end RollerRigStop;
