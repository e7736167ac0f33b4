within RailBraking.Validation;
model LockedWheel "Locked wheels stop the train in v^2/(2 mu g)"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-5);

  parameter Types.Velocity start_speed = 20 "Speed at the start";
  parameter Types.Ratio mu0 = 0.2 "Friction, independent of the slip speed";
  parameter Types.Mass m = 28000 "Mass on two wheelsets";
  final parameter Types.Length s_exact = start_speed^2/(2*mu0*g) "Closed-form braking distance";
  Components.TrainBody body(m=m, c_drag=0, start_speed=start_speed) "Masses along the track";
  Components.Wheelsets wheels(
    final n=2, J=222, r=0.38, curve={Data.CreepCurve(k_A=1, k_S=1, A=1, B=0) for i in 1:2},
    w_start=0, mu_bearing=1e-9, e_rolling=0) "Locked wheelsets";
equation
  wheels.v = body.v;
  wheels.load = {m*g/2, m*g/2};
  wheels.mu0 = {mu0, mu0};
  wheels.brake_torque = 1e6;
  wheels.standstill = body.standstill;
  body.F = sum(wheels.F);
  body.track_force = 0;
  body.capacity = wheels.capacity;
  error = if body.standstill then body.s/s_exact - 1 else 0;
  annotation (
    experiment(StopTime=12, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
With k_A = k_S the two terms of Polach add up to full friction at large slip. The remaining error,
1e-6, is due to the regularised slip near standstill.
</p>
</html>"));
end LockedWheel;
