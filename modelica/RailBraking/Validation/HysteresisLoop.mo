within RailBraking.Validation;
model HysteresisLoop "The pad force is below the mean when applying and above it when releasing"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-4);

  Pneumatics.HystereticRigging rigging(A_piston=0.0324, i_rigging=6, eta_rigging=0.95, F_spring=1200, hysteresis=0.06)
    "Rigging with friction";
  Pneumatics.Rigging mean(A_piston=0.0324, i_rigging=6, eta_rigging=0.95, F_spring=1200) "Rigging without";
  Types.Pressure p(start=0, fixed=true) "Pressure, rising and falling";
  Types.PressureRate rate "Rate of the pressure";
equation
  rate = if time < 2 then 1.5e5 else -1.5e5;
  der(p) = rate;
  rigging.pressure = p;
  mean.pressure = p;
  error = if time > 1 and time < 2 then rigging.pad_force/mean.pad_force - 0.94 else if time > 3 and time < 3.5
    then rigging.pad_force/mean.pad_force - 1.06 else 0;
  annotation (
    experiment(StopTime=4, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>After ten times p_reverse the friction has reversed completely.</p>
</html>"));
end HysteresisLoop;
