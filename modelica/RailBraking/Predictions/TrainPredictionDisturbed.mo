within RailBraking.Predictions;
block TrainPredictionDisturbed "Two-part train as an estimator believes it to be, on a track that it does not know"
  extends TrainPrediction(disturbance = d, acceleration = a + bias);
  Types.Acceleration d(start=0, fixed=true, stateSelect=StateSelect.always)
    "What moves the train and is in no other equation: gradient, curve, wind";
  Types.Acceleration bias(start=0, fixed=true, stateSelect=StateSelect.always) "What the accelerometer shows too much";
equation
  der(d) = 0;
  der(bias) = 0;
  annotation (
    Documentation(info="<html>
<p>
Twenty-seven states: those of <a
href=\"modelica://RailBraking.Predictions.TrainPrediction\">TrainPrediction</a>, then d and
bias. Speed over ground and accelerometer disagree by the bias; the accelerometer and the adhesion that the torques of
the wheelsets tell, by d. Once both are known, the accelerometer alone tells the speed for as long as nothing else does.
</p>
<h4>Limitations</h4>
<p>
Those of <a
href=\"modelica://RailBraking.Predictions.TrainPrediction\">TrainPrediction</a>. While all pads rub with friction
that is not known either, d is known from the time before the brake was on, and from how smooth it is. An accelerometer
that feels gravity along the track shows -d as a part of its bias.
</p>
</html>"));
end TrainPredictionDisturbed;
