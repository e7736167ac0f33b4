within RailBraking.Examples;
model Predictions "The two prediction models beside each other, braked at a constant adhesion"
  FMUs.TrainPrediction full(alpha_start={0.12, 0.08, 0.08, 0.12}) "With suspension";
  FMUs.TrainPredictionReduced reduced(alpha_start={0.12, 0.08, 0.08, 0.12}) "Without suspension";
equation
  full.cylinder_pressure = {3e5, 2e5, 2e5, 3e5};
  reduced.cylinder_pressure = {3e5, 2e5, 2e5, 3e5};
  full.track_force = 0;
  reduced.track_force = 0;
  annotation (
    experiment(StopTime=2, Tolerance=1e-8, Interval=0.001),
    Documentation(info="<html>
<p>
Adhesion and pad friction keep their values: without readings a prediction drifts away from any real train, wheels
lock or spin up.
</p>
</html>"));
end Predictions;
