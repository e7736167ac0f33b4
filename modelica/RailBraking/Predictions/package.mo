within RailBraking;
package Predictions "Vehicles and test rigs as modelled by an estimator"
  annotation (Documentation(info="<html>
<p>
Each block becomes an FMU for Model Exchange and the model inside a Kalman filter. It is smooth and free of events, so
that its Jacobian exists in every state. Unknown quantities, such as the adhesion, are states that
only readings change.
</p>
<p>Every parameter has a value, because FMI requires a start value; the filter sets all of them.</p>
</html>"));
end Predictions;
