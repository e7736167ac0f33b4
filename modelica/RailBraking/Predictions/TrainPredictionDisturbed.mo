within RailBraking.Predictions;
block TrainPredictionDisturbed "Two-part train as modelled by an estimator that does not know the track"
  extends TrainPrediction(disturbance = d, acceleration = a + bias);
  Types.Acceleration d(start=0, fixed=true, nominal=0.1, stateSelect=StateSelect.always)
    "Acceleration by forces in no other equation: gradient, curve, wind";
  Types.Acceleration bias(start=0, fixed=true, nominal=0.1, stateSelect=StateSelect.always) "Bias of the accelerometer";
equation
  der(d) = 0;
  der(bias) = 0;
  annotation (
    Documentation(info="<html>
<p>
Twenty-seven states: those of <a
href=\"modelica://RailBraking.Predictions.TrainPrediction\">TrainPrediction</a>, then d and
bias. The bias is the difference between accelerometer and speed over ground; d is that between
accelerometer and the adhesion that follows from the torques of the wheelsets. When both are known,
the accelerometer alone determines the speed while there is no other reading of it.
</p>
<h4>Limitations</h4>
<p>
Those of <a
href=\"modelica://RailBraking.Predictions.TrainPrediction\">TrainPrediction</a>. While all pads
brake with unknown friction, d is known only from the time before the brake application, and because
it changes slowly. For an accelerometer that measures gravity along the track, -d is a part of the
bias.
</p>
</html>"));
end TrainPredictionDisturbed;
