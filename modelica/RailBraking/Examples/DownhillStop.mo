within RailBraking.Examples;
model DownhillStop "Stop on a falling gradient in a curve and on level track"
  extends Icons.Example;
  Plants.TwoPartTrain train(start_speed=60/3.6) "Train on the gradient"
    annotation(Placement(transformation(extent={{-60, 20}, {-20, 60}})));
  Plants.TwoPartTrain train_level(start_speed=60/3.6) "Train on level track"
    annotation(Placement(transformation(extent={{20, 20}, {60, 60}})));
  Tracks.UniformTrack track(m=84000, gradient=-0.02, curvature=1/500, begin=50)
    "Twenty per mille downhill, radius 500 m"
    annotation(Placement(transformation(extent={{-60, -60}, {-20, -20}})));
  Tracks.LevelTrack level(m=84000) "Straight level track"
    annotation(Placement(transformation(extent={{20, -60}, {60, -20}})));
equation
  connect(train.distance, track.distance)
    annotation(Line(points={{-20, 40}, {-40, 40}, {-40, -40}, {-60, -40}}, color={0, 0, 127}));
  connect(train_level.distance, level.distance)
    annotation(Line(points={{60, 40}, {40, 40}, {40, -40}, {20, -40}}, color={0, 0, 127}));
  connect(track.track_force, train.track_force)
    annotation(Line(points={{-20, -40}, {-40, -40}, {-40, 40}, {-60, 40}}, color={0, 0, 127}));
  connect(level.track_force, train_level.track_force)
    annotation(Line(points={{60, -40}, {40, -40}, {40, 40}, {20, 40}}, color={0, 0, 127}));
  train.pressure_command = train.p_max;
  train_level.pressure_command = train_level.p_max;
  train.mu0 = fill(0.3, 6);
  train_level.mu0 = fill(0.3, 6);
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    experiment(StopTime=25, Tolerance=1e-6, Interval=0.01),
    Documentation(info="<html>
<p>Both trains come to rest and are held there, one against a slope of 16 kN.</p>
</html>"));
end DownhillStop;
