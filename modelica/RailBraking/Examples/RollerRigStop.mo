within RailBraking.Examples;
model RollerRigStop "Wheelset on the roller, braked into a slide and released"
  FMUs.RollerRig rig(speed_start=30) "Rig";
equation
  rig.mu0 = 0.06;
  rig.valve_command = if time < 1 then 0 elseif time < 3 then 1 else -1;
  annotation (
    experiment(StopTime=6, Tolerance=1e-7, Interval=0.01),
    Documentation(info="<html>
<p>The wheelset slides from about 1.5 s on, and turns with the roller again after the release.</p>
</html>"));
end RollerRigStop;
