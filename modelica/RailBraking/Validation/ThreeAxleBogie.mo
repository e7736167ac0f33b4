within RailBraking.Validation;
model ThreeAxleBogie "A bogie of three axles shifts the load by the closed form"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-6);

  parameter Types.Torque tau = 20e3 "Torque that tips the frame";
  parameter Types.Length wheelbase = 3.6 "Distance of the first and the last wheelset";
  Components.BogieFrame frame(
    final n=3, m_wheelset={20000, 20000, 20000}, m_unsprung={2500, 2500, 2500}, m_frame=6000, I_frame=6000,
    h_frame=0.6, h_rod=0.5, wheelbase=wheelbase, r_wheel=0.55, k=2e6, c=6e4) "Bogie of a locomotive";
equation
  frame.F = 0;
  frame.a = 0;
  frame.torque = tau;
  frame.rail_height = fill(0, 3);
  frame.rail_rate = fill(0, 3);
  frame.rail_acceleration = fill(0, 3);
  error = if time < 4 then 0 else
    abs((frame.load[1] - 20000*g)/(tau/wheelbase) - 1) + abs(frame.load[2]/(20000*g) - 1)
    + abs((frame.load[3] - 20000*g)/(tau/wheelbase) + 1);
  annotation (
    experiment(StopTime=5, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
Load moves by tau x<sub>i</sub>/&Sigma;x&sup2;: by tau/wheelbase at the outer wheelsets, and zero in the middle.
</p>
</html>"));
end ThreeAxleBogie;
