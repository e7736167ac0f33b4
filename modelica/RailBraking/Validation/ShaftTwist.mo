within RailBraking.Validation;
model ShaftTwist "Wheels and brake discs swing against each other as two inertias on a damped spring"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-4);

  parameter Types.AngularVelocity w_start = 1 "Speed of the wheels at the start, the brake discs being at rest";
  Components.ElasticShaft shaft(n=2, J_total=220, w_start=w_start) "Two wheelsets";
  Types.AngularVelocity w(start=0, fixed=true) "Angular velocity of the brake discs";
protected
  final parameter Real decay(final unit="1/s") = 2*400/(2*220*0.3*0.7) "Damping over twice the reduced inertia";
  final parameter Types.AngularVelocity w_swing = sqrt(2*6e6/(220*0.3*0.7) - decay^2) "Angular frequency";
equation
  shaft.w = w;
  shaft.tau_wheel = 0;
  shaft.J_braked*der(w) = shaft.tau;
  error = (shaft.w_wheel - w)/w_start - exp(-decay*time)*(cos(w_swing*time) - decay/w_swing*sin(w_swing*time));
  annotation (
    experiment(StopTime=0.6, Tolerance=1e-8, Interval=0.001),
    Documentation(info="<html>
<p>
With the reduced inertia J = wheel_share (1 - wheel_share) J_total the twist x obeys J x'' + n d x' + n k x = 0 with
x(0) = 0 and x'(0) = w_start.
</p>
</html>"));
end ShaftTwist;
