within RailBraking.Validation;
model MomentumKept "Force times time is mass times speed, including rotating masses"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-5);

  parameter Types.Mass m = 28000 "Mass on two wheelsets";
  parameter Types.Force pull = 20e3 "Force of the track, forward";
  Components.TrainBody body(m=m, c_drag=0, start_speed=10) "Masses along the track";
  Components.Wheelsets wheels(
    final n=2, J=222, r=0.38, curve={Data.CreepCurve(k_A=1, k_S=0.4, A=0.4, B=0.6) for i in 1:2},
    w_start=10/0.38, mu_bearing=1e-9, e_rolling=0)
    "Free wheelsets";
  Types.Velocity v_exact "Speed without creep";
equation
  wheels.v = body.v;
  wheels.load = {m*g/2, m*g/2};
  wheels.mu0 = {0.5, 0.5};
  wheels.brake_torque = 0;
  wheels.standstill = body.standstill;
  body.F = sum(wheels.F);
  body.track_force = pull;
  body.capacity = wheels.capacity;
  v_exact = 10 + pull*time/(m + 222/0.38^2);
  error = body.v/v_exact - 1;
  annotation (
    experiment(StopTime=10, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>The wheels creep by 4e-6 while they are accelerated, which is the error.</p>
</html>"));
end MomentumKept;
