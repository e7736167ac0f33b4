within RailBraking.Validation;
model CarsOnACoupler "Two cars oscillate on an undamped coupler at its natural frequency"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-4);

  parameter Types.Mass m1 = 40e3 "Mass of the leading car";
  parameter Types.Mass m2 = 25e3 "Mass of the car behind";
  parameter Types.Stiffness k = 5e6 "Stiffness of the coupler";
  parameter Types.Force F = 20e3 "Force on the leading car from the start";
  final parameter Real w0(final unit="rad/s") = sqrt(k*(1/m1 + 1/m2)) "Natural frequency";
  Components.CarBody leading(m=m1, start_speed=10, drag(c_drag=0)) "Leading car";
  Components.CarBody trailing(m=m2, start_speed=10, drag(c_drag=0)) "Car behind";
  Components.Coupler coupler(k=k, c=0) "Coupler";
equation
  leading.track_force = F;
  leading.standstill = false;
  trailing.track_force = 0;
  trailing.standstill = false;
  connect(leading.rear, coupler.front);
  connect(coupler.rear, trailing.front);
  error = coupler.x/(F/m1/w0^2) - (1 - cos(w0*time));
  annotation (
    experiment(StopTime=2, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>A step of the force stretches the coupler by F/(m1 w0&sup2;) (1 - cos w0 t), w0&sup2; = k (1/m1 + 1/m2).</p>
</html>"));
end CarsOnACoupler;
