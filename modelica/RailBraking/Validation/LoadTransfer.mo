within RailBraking.Validation;
model LoadTransfer "Braking shifts the load by the closed form"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-6);

  parameter Types.Force F = 40e3 "Braking force of the track on both wheelsets";
  parameter Types.Acceleration a = -1 "Constant acceleration";
  parameter Types.Torque tau = 16e3 "Brake torque on both wheelsets";
  final parameter Types.Torque tipping = tau + (F + 3000*a)*(0.55 - 0.38) - (F + 6500*a)*(0.55 - 0.40)
    "Torque on the frame";
  Components.BogieFrame frame(
    m_wheelset={13400, 14100}, m_unsprung={1500, 1500}, m_frame=3500, I_frame=2200, h_frame=0.55, h_rod=0.40,
    wheelbase=1.9,
    r_wheel=0.38, k=2.4e6, c=2.4e4) "Leading motor bogie";
  Components.BogieFrame massless(
    m_wheelset={13400, 14100}, m_unsprung={0, 0}, m_frame=1e-3, I_frame=2200, h_frame=0.55, h_rod=0.40,
    wheelbase=1.9,
    r_wheel=0.38, k=2.4e6, c=2.4e4) "The same without mass, at constant wheel speed";
equation
  frame.F = F;
  frame.a = a;
  frame.torque = tau;
  frame.rail_height = fill(0, 2);
  frame.rail_rate = fill(0, 2);
  frame.rail_acceleration = fill(0, 2);
  massless.F = F;
  massless.a = a;
  massless.torque = 0.38*F;
  massless.rail_height = fill(0, 2);
  massless.rail_rate = fill(0, 2);
  massless.rail_acceleration = fill(0, 2);
  error = if time < 4.9 then 0 else max({
    abs(frame.load[1] - 13400*g - tipping/1.9), abs(frame.load[2] - 14100*g + tipping/1.9),
    abs(massless.load[1] - 13400*g - F*0.40/1.9), abs(massless.load[2] - 14100*g + F*0.40/1.9)})/8e3;
  annotation (
    experiment(StopTime=5, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>The second bogie verifies the rule &plusmn;&Sigma;F h_rod/wheelbase.</p>
</html>"));
end LoadTransfer;
