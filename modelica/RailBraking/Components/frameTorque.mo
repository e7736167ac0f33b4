within RailBraking.Components;
function frameTorque "Torque that pitches a bogie frame nose-down in braking, without springs"
  extends Icons.Function;
  input Types.Force F "Braking force of the track on both wheelsets together";
  input Types.Torque tau "Brake torque on both wheelsets together";
  input Types.Acceleration a "Acceleration along the track";
  input Types.Mass m_unsprung "Mass of both wheelsets together";
  input Types.Mass m_frame "Mass of the frame";
  input Types.Length h_frame "Height of the frame's centre of gravity over the rail";
  input Types.Length h_rod "Height of the traction rod over the rail";
  input Types.Length r_wheel "Height of the axles over the rail";
  output Types.Torque torque "Torque about the frame's centre of gravity";
protected
  Types.Force X "Force of the frame on its wheelsets, forward";
  Types.Force rod "Force of the car body on the frame, forward";
algorithm
  X := F + m_unsprung*a;
  rod := X + m_frame*a;
  torque := tau + X*(h_frame - r_wheel) - rod*(h_frame - h_rod);
  annotation (
    smoothOrder=100,
    Inline=true,
    Documentation(info="<html>
<p>
Without masses and at constant wheel speed, where tau = F r_wheel, this is F h_rod: the height of the rod alone
decides the load transfer.
</p>
<h4>Syntax</h4>
<blockquote><pre>
torque = Components.<strong>frameTorque</strong>(F, tau, a, m_unsprung, m_frame, h_frame, h_rod, r_wheel);
</pre></blockquote>
<h4>Limitations</h4>
<p>Bearing and rolling resistance, below one per cent of the brake torque, do not act on the frame.</p>
</html>"));
end frameTorque;
