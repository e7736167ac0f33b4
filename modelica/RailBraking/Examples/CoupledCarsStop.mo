within RailBraking.Examples;
model CoupledCarsStop "Emergency stop of two coupled cars of which one does not brake"
  extends Icons.Example;
  Plants.Consist train(
    cars=2, start_speed=60/3.6, k_A=dry.k_A, k_S=dry.k_S, A_falling=dry.A, B_falling=dry.B, k_coupler=1e7,
    c_coupler=2e5, slack_coupler=0.04) "Train"
    annotation(Placement(transformation(extent={{-60, -20}, {-20, 20}})));
  parameter Contact.Surfaces.Dry dry "Rail"
    annotation(Placement(transformation(extent={{20, -20}, {60, 20}})));
  Types.Ratio build_up "Share of full pressure after 0.4 s of dead time, with a time constant of 0.5 s";
equation
  build_up = if time < 0.4 then 0 else 1 - exp(-(time - 0.4)/0.5);
  train.pressure_command = build_up*{3e5, 3e5, 3e5, 3e5, 0, 0, 0, 0};
  train.mu0 = fill(dry.mu0, 8);
  train.track_force = 0;
  train.car_track_force = zeros(2);
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    experiment(StopTime=60, Tolerance=1e-6, Interval=0.01),
    Documentation(info="<html>
<p>
The second car runs into the first through the slack and is then braked by the coupler. Watch
<code>train.coupler_force</code> and <code>train.speed</code>.
</p>
</html>"));
end CoupledCarsStop;
