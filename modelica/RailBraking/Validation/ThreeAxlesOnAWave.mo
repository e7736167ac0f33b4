within RailBraking.Validation;
model ThreeAxlesOnAWave "Three wheelsets on a rail of a single wave carry the weight and its closed-form oscillation"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-3);

  parameter Types.Velocity v = 30 "Speed";
  parameter Types.Length distance = 1.8 "Distance of neighbouring wheelsets";
  Tracks.UnevenRail rail(n=3, behind={0, distance, 2*distance}, lines=1, longest=10, shortest=10/1.5)
    "Rail of one wave";
  Components.BogieFrame frame(
    final n=3, m_wheelset={19000, 20000, 21000}, m_unsprung={2500, 2500, 2500}, m_frame=6000, I_frame=6000,
    h_frame=0.6, h_rod=0.5, wheelbase=2*distance, r_wheel=0.55, k=2e6, c=6e4) "Bogie of a locomotive";
protected
  constant Types.Ratio pi = 3.14159265358979 "Circumference over diameter";
  final parameter Types.Curvature wavenumber = 2*pi/10*sqrt(1.5) "Wavenumber of the wave";
  final parameter Real w(final unit="rad/s") = wavenumber*v "Angular frequency of the wave";
  final parameter Types.Length amplitude = sqrt(
    2*10.80e-7*0.8246^2/((wavenumber^2 + 0.0206^2)*(wavenumber^2 + 0.8246^2))*wavenumber*(sqrt(1.5) - 1/sqrt(1.5)))
    "Height of the wave";
  final parameter Types.Ratio others = 2*(1 - cos(wavenumber*distance))
    "Three minus the sum of the three heights over that in the middle";
  final parameter Types.Stiffness stiffness = 3*2e6 - 6000*w^2 "Real part of the impedance of the frame";
  final parameter Types.Stiffness damping = 3*6e4*w "Imaginary part of the impedance of the frame";
  final parameter Types.Stiffness re = others*2e6 - 6000*w^2 "Real part of the impedance that is left";
  final parameter Types.Stiffness im = others*6e4*w "Imaginary part of the impedance that is left";
  final parameter Types.Ratio share_re = (re*stiffness + im*damping)/(stiffness^2 + damping^2)
    "Deflection in the middle over the height of the rail, real part";
  final parameter Types.Ratio share_im = (im*stiffness - re*damping)/(stiffness^2 + damping^2) "Imaginary part";
  final parameter Types.Force in_phase = amplitude*(2e6*share_re - 6e4*w*share_im - 2500*w^2)
    "Part of the load in phase with the rail";
  final parameter Types.Force ahead = amplitude*(2e6*share_im + 6e4*w*share_re)
    "Part a quarter of a period ahead of it";
  Types.Angle angle "Angle of the wave under the wheelset in the middle";
equation
  rail.v = v;
  frame.rail_height = rail.height;
  frame.rail_rate = rail.rate;
  frame.rail_acceleration = rail.acceleration;
  frame.F = 0;
  frame.a = 0;
  frame.torque = 0;
  angle = w*time - wavenumber*distance + 2*pi*0.618033988749895;
  error = if time < 3 then 0 else
    (frame.load[2] - 20000*g - in_phase*cos(angle) + ahead*sin(angle))/sqrt(in_phase^2 + ahead^2);
  annotation (
    experiment(StopTime=6, Tolerance=1e-8, Interval=0.001),
    Documentation(info="<html>
<p>
With a wave Z exp(i w t) in the middle, whose three heights add up to Z (3 - others), S = k + i w c and the mass M of
the frame, its bounce is -S (3 - others) Z/(3 S - M w&sup2;). Pitch does not reach the middle: the deflection is Z
(others S - M w&sup2;)/(3 S - M w&sup2;), and the load that times S, minus w&sup2; Z times the mass of the wheelset. It
oscillates about the weight for good.
</p>
</html>"));
end ThreeAxlesOnAWave;
