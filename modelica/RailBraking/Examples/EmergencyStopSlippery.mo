within RailBraking.Examples;
model EmergencyStopSlippery "Emergency stop from 80 km/h on a slippery rail without wheel-slide protection"
  extends Icons.Example;
  Plants.TwoPartTrain train(start_speed=80/3.6) "Train; its surface is that of a wet rail"
    annotation(Placement(transformation(extent={{-20, -20}, {20, 20}})));
  Types.Ratio build_up "Share of full pressure after 0.4 s of dead time, with a time constant of 0.5 s";
equation
  build_up = if time < 0.4 then 0 else 1 - exp(-(time - 0.4)/0.5);
  train.pressure_command = build_up*train.p_max;
  train.mu0 = {0.10, 0.10, 0.10, 0.10, 0.10, 0.10};
  train.track_force = 0;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    experiment(StopTime=45, Tolerance=1e-6, Interval=0.01),
    Documentation(info="<html>
<p>
The motor bogies lock within three seconds; then the train brakes more slowly, the rotating masses of the trailer
wheelsets help less, and these lock as well. Watch <code>train.locked</code> and <code>train.group_adhesion</code>.
</p>
</html>"));
end EmergencyStopSlippery;
