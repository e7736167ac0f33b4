within RailBraking.Validation;
model FrameOnAWave "A bogie on a rail of a single wave moves the load as its transmission from rail to frame demands"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-3);

  parameter Types.Velocity v = 30 "Speed";
  Tracks.UnevenRail rail(n=2, behind={0, 0}, lines=1, longest=10, shortest=10/1.5) "Rail of one wave, under a point";
  Components.BogieFrame frame(
    m_wheelset={13400, 14100}, m_unsprung={1500, 1500}, m_frame=3500, I_frame=2200, h_frame=0.55, h_rod=0.40,
    wheelbase=1.9,
    r_wheel=0.38, k=2.4e6, c=2.4e4) "Leading motor bogie, both wheelsets on the same point of the rail";
protected
  constant Types.Ratio pi = 3.14159265358979 "Circumference over diameter";
  final parameter Real w(final unit="rad/s") = 2*pi/10*sqrt(1.5)*v "Angular frequency of the wave";
  final parameter Types.Length amplitude = sqrt(
    2*10.80e-7*0.8246^2/((w^2/v^2 + 0.0206^2)*(w^2/v^2 + 0.8246^2))*w/v*(sqrt(1.5) - 1/sqrt(1.5)))
    "Height of the wave";
  final parameter Types.Stiffness stiffness = 2*2.4e6 - 3500*w^2 "Real part of the impedance of the frame";
  final parameter Types.Stiffness damping = 2*2.4e4*w "Imaginary part of the impedance of the frame";
  final parameter Real re(final unit="kg.N/m") = 3500*2*2.4e6 + 2*1500*stiffness "Real part of the common numerator";
  final parameter Real im(final unit="kg.N/m") = (3500 + 2*1500)*damping "Imaginary part of the numerator";
  final parameter Types.Force in_phase =
    -w^2*amplitude*(re*stiffness + im*damping)/(stiffness^2 + damping^2) "Part of the load in phase with the rail";
  final parameter Types.Force ahead =
    w^2*amplitude*(im*stiffness - re*damping)/(stiffness^2 + damping^2) "Part a quarter of a period ahead of it";
  Types.Angle angle "Angle of the wave under the wheelsets";
  Types.Force load "Load of both wheelsets, change from static";
equation
  rail.v = v;
  frame.rail_height = rail.height;
  frame.rail_rate = rail.rate;
  frame.rail_acceleration = rail.acceleration;
  frame.F = 0;
  frame.a = 0;
  frame.torque = 0;
  angle = w*time + 2*pi*0.618033988749895;
  load = sum(frame.load) - 27500*g;
  error = if time < 3 then 0 else
    (load - in_phase*cos(angle) - ahead*sin(angle))/sqrt(in_phase^2 + ahead^2);
  annotation (
    experiment(StopTime=4, Tolerance=1e-8, Interval=0.001),
    Documentation(info="<html>
<p>
With z the height of the rail, y the compression of both springs, and M the mass of the frame: M y'' + 2 c y' + 2 k y =
M z''. The load of both wheelsets is 2 (k y + c y') + 2 m z'', with the unsprung mass m of a wheelset: for a wave
Z exp(i w t) it is
-w&sup2; Z (M (2 k + 2 i w c)/(2 k - M w&sup2; + 2 i w c) + 2 m) exp(i w t).
</p>
</html>"));
end FrameOnAWave;
