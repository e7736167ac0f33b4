within RailBraking.Examples;
model RollerRigStop "Wheelset on the roller, braked into a slide and released"
  extends Icons.Example;
  Plants.RollerRig rig(start_speed=30) "Rig"
    annotation(Placement(transformation(extent={{-20, -20}, {20, 20}})));
equation
  rig.mu0 = 0.06;
  rig.valve_command = if time < 1 then 0 elseif time < 3 then 1 else -1;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    experiment(StopTime=6, Tolerance=1e-7, Interval=0.01),
    Documentation(info="<html>
<p>The wheelset slides from about 1.5 s on, and turns with the roller again after the release.</p>
</html>"));
end RollerRigStop;
