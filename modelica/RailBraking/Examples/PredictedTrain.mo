within RailBraking.Examples;
model PredictedTrain "Comparison of the prediction models of a train braked at a constant adhesion"
  extends Icons.Example;
  Predictions.TrainPrediction full(alpha_start={0.12, 0.08, 0.08, 0.12}) "With suspension"
    annotation(Placement(transformation(extent={{-60, -20}, {-20, 20}})));
  Predictions.TrainPredictionReduced reduced(alpha_start={0.12, 0.08, 0.08, 0.12}) "Without suspension"
    annotation(Placement(transformation(extent={{20, -20}, {60, 20}})));
  Predictions.TrainPredictionDisturbed disturbed(alpha_start={0.12, 0.08, 0.08, 0.12}, d(start=-0.05))
    "With suspension, on a rising gradient that it estimates"
    annotation(Placement(transformation(extent={{20, -80}, {60, -40}})));
  Predictions.TrainPredictionLoaded loaded(alpha_start={0.12, 0.08, 0.08, 0.12}, payload(start=0.1))
    "With suspension, of a load that it estimates"
    annotation(Placement(transformation(extent={{-60, -80}, {-20, -40}})));
  Predictions.TrainPredictionReducedDisturbed reducedDisturbed(
    alpha_start={0.12, 0.08, 0.08, 0.12}, d(start=-0.05)) "Without suspension, on a rising gradient that it estimates"
    annotation(Placement(transformation(extent={{20, 40}, {60, 80}})));
equation
  disturbed.cylinder_pressure = {3e5, 2e5, 2e5, 3e5};
  disturbed.track_force = 0;
  reducedDisturbed.cylinder_pressure = {3e5, 2e5, 2e5, 3e5};
  reducedDisturbed.track_force = 0;
  loaded.cylinder_pressure = {3e5, 2e5, 2e5, 3e5};
  loaded.track_force = 0;
  full.cylinder_pressure = {3e5, 2e5, 2e5, 3e5};
  reduced.cylinder_pressure = {3e5, 2e5, 2e5, 3e5};
  full.track_force = 0;
  reduced.track_force = 0;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    experiment(StopTime=2, Tolerance=1e-8, Interval=0.001),
    Documentation(info="<html>
<p>
Adhesion and pad friction keep their values, because there are no readings: wheels lock or spin up.
</p>
</html>"));
end PredictedTrain;
