within RailBraking.Examples;
model ProtectedStop "Stop from 50 km/h on a slippery rail with valves and a plain slip control"
  extends Icons.Example;
  parameter Types.Ratio slip_low = 0.10 "Slip below which a group is filled";
  parameter Types.Ratio slip_high = 0.15 "Slip above which a group is vented";
  Plants.TwoPartTrainPneumatic train(start_speed=50/3.6, hysteresis=0.06) "Train"
    annotation(Placement(transformation(extent={{-20, -20}, {20, 20}})));
equation
  for i in 1:4 loop
    train.valve_command[i] = if train.slip[i] > slip_high and train.speed > 1 then -1
      elseif train.slip[i] < slip_low or train.speed <= 1
      then 1 else 0;
  end for;
  train.mu0 = {0.08, 0.08, 0.085, 0.09, 0.095, 0.095};
  train.track_force = 0;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    experiment(StopTime=30, Tolerance=1e-6, Interval=0.01),
    Documentation(info="<html>
<p>
Three-state control on the true slip: vent above 15 %, fill below 10 %, hold between. Watch <code>train.slip</code>,
<code>train.cylinder_pressure</code> and <code>train.air_used</code>. Below 1 m/s the brake stays applied.
</p>
</html>"));
end ProtectedStop;
