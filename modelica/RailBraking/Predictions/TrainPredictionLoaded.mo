within RailBraking.Predictions;
block TrainPredictionLoaded "Two-part train as an estimator believes it to be, of a load that it does not know"
  extends TrainPrediction(
    static = g*(1 + payload)*m_group,
    disturbance = d - payload/(1 + payload)*(thrust - rho_air/2*c_drag*A_drag*v^2)/m,
    acceleration = a + bias);
  Types.Acceleration d(start=0, fixed=true, stateSelect=StateSelect.always)
    "What moves the train and is in no other equation: gradient, curve, wind";
  Types.Acceleration bias(start=0, fixed=true, stateSelect=StateSelect.always) "What the accelerometer shows too much";
  Types.Ratio payload(start=0, fixed=true, stateSelect=StateSelect.always)
    "Mass of the train over the one that it is believed to have, minus one";
equation
  der(d) = 0;
  der(bias) = 0;
  der(payload) = 0;
  annotation (
    Documentation(info="<html>
<p>
Twenty-eight states: those of <a
href=\"modelica://RailBraking.Predictions.TrainPredictionDisturbed\">TrainPredictionDisturbed</a>, then payload. Every
wheelset carries 1 + payload times its mass. What the springs of the primary suspension show, and what the inertia of a
wheelset takes when its speed changes, are forces; the accelerometer shows a force over the mass. Both together tell the
mass, the better the more the brake force varies.
</p>
<h4>Limitations</h4>
<p>
Those of <a
href=\"modelica://RailBraking.Predictions.TrainPredictionDisturbed\">TrainPredictionDisturbed</a>. All wheelsets are
heavier by the same share. With a constant brake force, a gradient that is not known is the same as a load.
</p>
</html>"));
end TrainPredictionLoaded;
