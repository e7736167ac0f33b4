within RailBraking.Validation;
model PadRelaxation "Relaxing pad friction follows its closed form"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-4);

  parameter Types.Ratio mu_start = 0.20 "Pad friction at the start";
  Predictions.RollerRigPrediction rig(start_speed=30, mu_b_start=mu_start, alpha_start=0.0015, mu_b_relaxes=1, T_mu=10)
    "Rolling, released";
protected
  Types.Time elapsed "Time of relaxation from the initial to the present friction";
equation
  rig.pad_force = 0;
  elapsed = rig.T_mu*(mu_start - rig.mu_b
    - rig.mu_b_rest*log((rig.mu_b_rest - rig.mu_b)/(rig.mu_b_rest - mu_start)));
  error = (elapsed - time)/5;
  annotation (
    experiment(StopTime=5, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
der(mu) = (mu_rest - mu)/(T mu) integrates to
time = T (mu_start - mu - mu_rest ln((mu_rest - mu)/(mu_rest - mu_start))).
The tolerance is that of the rounded guard, 1e-5 in the rate, and of a solver.
</p>
</html>"));
end PadRelaxation;
