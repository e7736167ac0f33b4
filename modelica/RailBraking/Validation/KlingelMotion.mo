within RailBraking.Validation;
model KlingelMotion "A free wheelset oscillates with Klingel's wavelength"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=0.02);

  parameter Types.Velocity v = 1 "Speed, low enough to neglect inertia";
  parameter Types.Length y_start = 1e-3 "Lateral position at the start";
  parameter Types.Ratio conicity = 0.15 "Conicity of the wheels";
  parameter Types.Length r = 0.42 "Rolling radius";
  parameter Types.Length b = 0.75 "Half the distance of the contacts";
  final parameter Real k(final unit="1/m") = sqrt(conicity/(r*b)) "Wavenumber after Klingel (1883)";
  Components.GuidedWheelset wheelset(
    m=1400, I_yaw=810, J=112, r=r, b=b, conicity=conicity, load_nominal=1.2e5, k_A=1, k_S=0.4, A=0.4, B=0.6,
    start_speed=v,
    y(start=y_start)) "Wheelset without frame";
equation
  wheelset.alignment = 0;
  wheelset.vertical = 0;
  wheelset.cross_level = 0;
  wheelset.gauge = 0;
  wheelset.mu0 = 0.5;
  error = (wheelset.y - y_start*cos(k*v*time))/y_start;
  annotation (
    experiment(StopTime=10, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
At low speed two wheels on one axle roll without sliding: y'' + conicity/(r b) y = 0 over the
distance, independent of the friction.
</p>
<h4>Limitations</h4>
<p>Valid within 2 % over one wavelength: the formula neglects finite creep stiffness and the
rounding of the flange spring, 0.03 MN/m. At higher speed, inertia increases the amplitude.</p>
</html>"));
end KlingelMotion;
