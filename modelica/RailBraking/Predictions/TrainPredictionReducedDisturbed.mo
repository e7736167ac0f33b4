within RailBraking.Predictions;
block TrainPredictionReducedDisturbed "Two-part train without suspension, on a track that the estimator does not know"
  extends TrainPredictionReduced(disturbance = d, acceleration = a + bias);
  Types.Acceleration d(start=0, fixed=true, nominal=0.1, stateSelect=StateSelect.always)
    "Acceleration by forces in no other equation: gradient, curve, wind";
  Types.Acceleration bias(start=0, fixed=true, nominal=0.1, stateSelect=StateSelect.always) "Bias of the accelerometer";
equation
  der(d) = 0;
  der(bias) = 0;
  annotation (
    Documentation(info="<html>
<p>
Fifteen states: those of <a
href=\"modelica://RailBraking.Predictions.TrainPredictionReduced\">TrainPredictionReduced</a>, then d and bias, which <a
href=\"modelica://RailBraking.Predictions.TrainPredictionDisturbed\">TrainPredictionDisturbed</a> explains.
</p>
<h4>Limitations</h4>
<p>
Those of <a
href=\"modelica://RailBraking.Predictions.TrainPredictionReduced\">TrainPredictionReduced</a> and of <a
href=\"modelica://RailBraking.Predictions.TrainPredictionDisturbed\">TrainPredictionDisturbed</a>.
</p>
</html>"));
end TrainPredictionReducedDisturbed;
