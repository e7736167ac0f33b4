within RailBraking.Validation;
model PitchMode "An undamped frame pitches at its natural frequency"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-4);

  parameter Types.Torque tau = 10e3 "Torque that appears at the start";
  final parameter Real w0(final unit="rad/s") = sqrt(2.4e6*1.9^2/2/2200) "Natural frequency";
  Components.BogieFrame frame(
    m_wheelset={13400, 14100}, m_unsprung={1500, 1500}, m_frame=3500, I_frame=2200, h_frame=0.55, h_rod=0.40,
    wheelbase=1.9,
    r_wheel=0.38, k=2.4e6, c=0) "Leading motor bogie";
equation
  frame.F = 0;
  frame.a = 0;
  frame.torque = tau;
  frame.rail_height = fill(0, 2);
  frame.rail_rate = fill(0, 2);
  frame.rail_acceleration = fill(0, 2);
  error = (frame.dz[1] - tau/(2.4e6*1.9)*(1 - cos(w0*time)))/(tau/(2.4e6*1.9));
  annotation (
    experiment(StopTime=1, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>After a step of torque the deflection oscillates between zero and twice its static value.</p>
</html>"));
end PitchMode;
