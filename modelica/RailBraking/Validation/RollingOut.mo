within RailBraking.Validation;
model RollingOut "Bearing and rolling resistance decelerate a train at a constant rate"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-5);

  parameter Types.Mass m = 28000 "Mass on two wheelsets";
  Components.TrainBody body(m=m, c_drag=0, start_speed=2) "Masses along the track";
  Components.Wheelsets wheels(
    final n=2, J=222, r=0.38, curve={Data.CreepCurve(k_A=1, k_S=0.4, A=0.4, B=0.6) for i in 1:2},
    w_start=2/0.38) "Free wheelsets";
  final parameter Types.Acceleration a_exact = (0.0018*0.065/0.38 + 0.0004/0.38)*m*g/(m + 222/0.38^2)
    "Closed-form deceleration";
  Types.Velocity v_exact "Speed without creep";
equation
  wheels.v = body.v;
  wheels.load = {m*g/2, m*g/2};
  wheels.mu0 = {0.5, 0.5};
  wheels.brake_torque = 0;
  wheels.standstill = body.standstill;
  body.F = sum(wheels.F);
  body.track_force = 0;
  body.capacity = wheels.capacity;
  v_exact = 2 - a_exact*time;
  error = (body.v - v_exact)/2;
  annotation (
    experiment(StopTime=100, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>The exact bearing formula differs from mu_bearing r_bearing/r by 2e-6; the rest is creep.</p>
</html>"));
end RollingOut;
