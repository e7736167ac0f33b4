within RailBraking.Examples;
model DownhillStop "Stop on a falling gradient in a curve, and the same on level track"
  FMUs.TwoPartTrain train(speed_start=60/3.6) "Train on the gradient";
  FMUs.TwoPartTrain train_level(speed_start=60/3.6) "Train on level track";
  Tracks.UniformTrack track(m=84000, gradient=-0.02, curvature=1/500, begin=50)
    "Twenty per mille downhill, radius 500 m";
  Tracks.LevelTrack level(m=84000) "Straight level track";
equation
  track.distance = train.distance;
  level.distance = train_level.distance;
  train.track_force = track.track_force;
  train_level.track_force = level.track_force;
  train.pressure_command = train.p_max;
  train_level.pressure_command = train_level.p_max;
  train.mu0 = fill(0.3, 6);
  train_level.mu0 = fill(0.3, 6);
  annotation (
    experiment(StopTime=25, Tolerance=1e-6, Interval=0.01),
    Documentation(info="<html>
<p>Both trains come to rest and are held there, one against a slope of 16 kN.</p>
</html>"));
end DownhillStop;
