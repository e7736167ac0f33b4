within RailBraking.Validation;
model CouplerForce "The force of a coupler is the share of the mass behind it"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-6);

  parameter Types.Mass m1 = 80e3 "Mass of the leading car, which is held back";
  parameter Types.Mass m2 = 30e3 "Mass of the car behind";
  parameter Types.Force F = 55e3 "Force that holds the leading car back";
  Components.CarBody leading(m=m1, start_speed=20, drag(c_drag=0)) "Leading car";
  Components.CarBody trailing(m=m2, start_speed=20, drag(c_drag=0)) "Car behind";
  Components.Coupler coupler(k=2e7, c=1e6) "Coupler";
equation
  leading.track_force = -F;
  leading.standstill = false;
  trailing.track_force = 0;
  trailing.standstill = false;
  connect(leading.rear, coupler.front);
  connect(coupler.rear, trailing.front);
  error = if time < 2 then 0 else abs(coupler.force + F*m2/(m1 + m2))/F + abs(leading.a + F/(m1 + m2));
  annotation (
    experiment(StopTime=3, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
The force is -F m2/(m1 + m2), a push, after the oscillation has decayed, and both cars have the acceleration -F/(m1 +
m2).
</p>
</html>"));
end CouplerForce;
