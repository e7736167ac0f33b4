within RailBraking.Predictions;
block TrainPredictionLoaded "Two-part train as modelled by an estimator that does not know the load"
  extends TrainPrediction(
    static = g*(1 + payload)*m_group,
    disturbance = d - payload/(1 + payload)*(thrust - rho_air/2*c_drag*A_drag*v^2)/m,
    acceleration = a + bias);
  Types.Acceleration d(start=0, fixed=true, nominal=0.1, stateSelect=StateSelect.always)
    "Acceleration by forces in no other equation: gradient, curve, wind";
  Types.Acceleration bias(start=0, fixed=true, nominal=0.1, stateSelect=StateSelect.always) "Bias of the accelerometer";
  Types.Ratio payload(start=0, fixed=true, nominal=0.1, stateSelect=StateSelect.always)
    "Relative difference of the mass of the train from the assumed mass";
equation
  der(d) = 0;
  der(bias) = 0;
  der(payload) = 0;
  annotation (
    Documentation(info="<html>
<p>
Twenty-eight states: those of <a
href=\"modelica://RailBraking.Predictions.TrainPredictionDisturbed\">TrainPredictionDisturbed</a>, then payload. Every
wheelset carries 1 + payload times its mass. The springs of the primary suspension and the inertia
of an accelerated wheelset determine forces; the accelerometer determines force over mass. Together
they determine the mass, more accurately if the brake force varies.
</p>
<h4>Limitations</h4>
<p>
Those of <a
href=\"modelica://RailBraking.Predictions.TrainPredictionDisturbed\">TrainPredictionDisturbed</a>. All wheelsets are
heavier by the same share. With a constant brake force, an unknown gradient cannot be distinguished from a load.
</p>
</html>"));
end TrainPredictionLoaded;
