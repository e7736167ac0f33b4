within RailBraking.Validation;
model HoldingOnSlope "Brakes hold a train on a slope up to the limit of their torque"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-6);

  parameter Types.Mass m = 28000 "Mass on two wheelsets";
  parameter Types.Torque brake_torque = 4000 "Torque of the brake";
  constant Types.Length r = 0.38 "Radius of the wheels";
  constant Types.Length s_unit = 1 "What creeping is counted in";
  constant Types.Velocity v_unit = 1 "What creeping is counted in";
  final parameter Types.Force F_exact = brake_torque/r "Force that the brake can hold";
  Components.TrainBody body(m=m, c_drag=0, start_speed=0) "Masses along the track";
  Components.Wheelsets wheels(
    final n=2, J=222, r=r, curve={Data.CreepCurve(k_A=1, k_S=0.4, A=0.4, B=0.6) for i in 1:2},
    w_start=0, mu_bearing=1e-9, e_rolling=0) "Braked wheelsets";
  Types.Force pull "Force of the slope, growing";
equation
  pull = 1000*time;
  wheels.v = body.v;
  wheels.load = {m*g/2, m*g/2};
  wheels.mu0 = {0.5, 0.5};
  wheels.brake_torque = brake_torque;
  wheels.standstill = body.standstill;
  body.F = sum(wheels.F);
  body.track_force = pull;
  body.capacity = wheels.capacity;
  error = if pull < F_exact then abs(body.v)/v_unit + body.s/s_unit
    else if pull > F_exact + 20 and body.v <= 0 then 1 else 0;
  annotation (
    experiment(StopTime=20, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>The train neither creeps before nor sticks after the force of the slope passes brake torque over radius.</p>
</html>"));
end HoldingOnSlope;
