within RailBraking.Validation;
model ReleaseFromLock "A locked group turns again as soon as the track's torque exceeds the brake's"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=2e-3);

  parameter Types.Mass m = 28000 "Mass on two wheelsets";
  parameter Types.Velocity v = 20 "Constant speed";
  constant Types.Length r = 0.38 "Radius of the wheels";
  constant Types.AngularVelocity w_unit = 1 "What turning backwards is counted in";
  Components.Wheelsets wheels(
    final n=2, J=222, r=r, curve={Data.CreepCurve(k_A=0.3, k_S=0.1, A=1, B=0) for i in 1:2},
    w_start=20/r, mu_bearing=1e-9, e_rolling=0)
    "Braked wheelsets";
  final parameter Types.Torque tau_track = r*m*g
    *Contact.polach(v/sqrt(v^2 + 0.01), v, m*g/4, 0.1, Contact.creepFactor(r, 0.30, 2.1e11, 0.28), 0.3, 0.1, 1, 0)
    "Torque of the track on locked wheels";
  Types.Torque brake_torque "Torque of the brake: grows, then falls";
equation
  brake_torque = if time < 4 then 5000*time else max(0, 20000 - 5000*(time - 4));
  wheels.v = v;
  wheels.load = {m*g/2, m*g/2};
  wheels.mu0 = {0.1, 0.1};
  wheels.brake_torque = brake_torque;
  wheels.standstill = false;
  error = if wheels.locked and time > 4 and brake_torque < tau_track - 20 then 1 else if time > 9.5
    then (wheels.w*r - v)/v else if wheels.w < 0 then wheels.w/w_unit else 0;
  annotation (
    experiment(StopTime=11, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
No group is locked while the track could turn it; a second and a half after the brake is off the wheels roll with the
train; at no time do
they turn backwards.
</p>
</html>"));
end ReleaseFromLock;
