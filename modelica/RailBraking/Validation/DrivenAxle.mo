within RailBraking.Validation;
model DrivenAxle "Energy taken by shaft torque and track brake is the energy that the car loses"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-6);

  parameter Types.Velocity start_speed = 10 "Speed at the start";
  final parameter Types.Energy E = 12e3*start_speed^2/2 + 110*(start_speed/0.42)^2/2 "Energy at the start";
  Components.Axle axle(
    J=110, r_wheel=0.42, n_units=2, r_friction=0.24, start_speed=start_speed,
    resistance(mu_bearing=1e-9, r_bearing=1e-9, e_rolling=0)) "Axle without brake";
  Components.CarBody body(m=12e3, start_speed=start_speed, drag(c_drag=0)) "Mass of a twelfth of a car";
  Components.ShaftTorque motor "Electrodynamic brake";
  Components.BodyForce magnet "Track brake";
  Types.Energy taken(start=0, fixed=true) "Energy taken by both, and heat of the contact";
equation
  connect(axle.box, body.pivot);
  connect(motor.shaft, axle.shaft);
  connect(magnet.pivot, body.pivot);
  motor.torque = -1500;
  magnet.force = -4000;
  axle.load = {12e3*g};
  axle.mu0 = {0.3};
  axle.pad_force = 0;
  axle.standstill = false;
  body.track_force = 0;
  body.standstill = false;
  der(taken) = motor.power + magnet.power + axle.totals.contact_power + axle.totals.pad_power;
  error = (body.kinetic_energy + axle.totals.kinetic_energy + taken)/E - 1;
  annotation (
    experiment(StopTime=8, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>The work of motor and magnet and the heat of contact and pads equal the lost kinetic energy.</p>
</html>"));
end DrivenAxle;
