within RailBraking.Validation;
model ReleasedPads "Friction of released pads is constant, that of applied pads settles"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-5);

  Friction.PadFriction released(mu_start=0.30) "Pads released";
  Friction.PadFriction applied(mu_start=0.30) "Pads applied at nominal force and speed";
  Friction.ConstantFriction constant_friction "Pads of constant friction";
equation
  released.pad_force = 3;
  released.pad_speed = 13;
  released.temperature = 333.15;
  applied.pad_force = 56e3;
  applied.pad_speed = 13;
  applied.temperature = 333.15;
  constant_friction.pad_force = 56e3;
  constant_friction.pad_speed = 13;
  constant_friction.temperature = 333.15;
  error = abs(released.mu - 0.30) + abs(applied.mu - 0.35 + 0.05*exp(-sqrt(1/9 + (56e3*13/2e5)^2)*time))
    + abs(constant_friction.mu - 0.35);
  annotation (
    experiment(StopTime=20, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>Applied pads settle within E_settle of friction work.</p>
</html>"));
end ReleasedPads;
