within RailBraking.Vehicles;
block ConsistPredictionDisturbed "Train of any number of groups and bogies on a track that the estimator does not know"
  extends Icons.Vehicle;
  extends ConsistPrediction(disturbance = d, acceleration = a + bias);
  Types.Acceleration d(start=0, fixed=true, nominal=0.1, stateSelect=StateSelect.always)
    "Acceleration by forces in no other equation: gradient, curve, wind";
  Types.Acceleration bias(start=0, fixed=true, nominal=0.1, stateSelect=StateSelect.always) "Bias of the accelerometer";
equation
  der(d) = 0;
  der(bias) = 0;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -40}, {-30, 30}, {20, 0}, {80, 50}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The states of <a href=\"modelica://RailBraking.Vehicles.ConsistPrediction\">ConsistPrediction</a>, and d and bias,
which <a href=\"modelica://RailBraking.Predictions.TrainPredictionDisturbed\">TrainPredictionDisturbed</a> explains.
</p>
<h4>Limitations</h4>
<p>
Those of <a href=\"modelica://RailBraking.Vehicles.ConsistPrediction\">ConsistPrediction</a> and of
<a href=\"modelica://RailBraking.Predictions.TrainPredictionDisturbed\">TrainPredictionDisturbed</a>.
</p>
</html>"));
end ConsistPredictionDisturbed;
