within RailBraking.Examples;
model EmergencyStopDry "Emergency stop from 85 km/h on a dry rail"
  extends Icons.Example;
  Plants.TwoPartTrain train(start_speed=85/3.6, k_A=dry.k_A, k_S=dry.k_S, A_falling=dry.A, B_falling=dry.B) "Train"
    annotation(Placement(transformation(extent={{-60, -20}, {-20, 20}})));
  parameter Contact.Surfaces.Dry dry "Rail"
    annotation(Placement(transformation(extent={{20, -20}, {60, 20}})));
  Types.Ratio build_up "Share of full pressure after 0.4 s of dead time, with a time constant of 0.5 s";
equation
  build_up = if time < 0.4 then 0 else 1 - exp(-(time - 0.4)/0.5);
  train.pressure_command = build_up*train.p_max;
  train.mu0 = fill(dry.mu0, 6);
  train.track_force = 0;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    experiment(StopTime=25, Tolerance=1e-6, Interval=0.01),
    Documentation(info="<html>
<p>The train stops after 265 m in 21.2 s. Watch <code>train.speed</code>, <code>train.pad_friction</code> and
<code>train.wheelset_load</code>.</p>
</html>"));
end EmergencyStopDry;
