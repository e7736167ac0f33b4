within RailBraking.Components;
function deflectionAcceleration "Second derivative of the deflection over one wheelset of a bogie"
  extends Icons.Function;
  input Types.Torque torque "Torque that tips the frame nose-down, springs excluded";
  input Types.Force spring "Spring and damper force over this wheelset, change from static, compression positive";
  input Types.Force spring_other "The same over the other wheelset";
  input Types.Mass m_frame "Mass of the frame";
  input Types.Inertia I_frame "Pitch inertia of the frame";
  input Types.Length arm "Distance of the wheelset ahead of the frame's centre, negative behind it";
  output Types.Acceleration a "Second derivative of the deflection";
protected
  Types.Acceleration bounce "Downward acceleration of the frame";
  Types.AngularAcceleration pitch "Nose-down angular acceleration of the frame";
algorithm
  bounce := -(spring + spring_other)/m_frame;
  pitch := (torque - (spring - spring_other)*arm)/I_frame;
  a := bounce + pitch*arm;
  annotation (
    smoothOrder=100,
    Inline=true,
    Documentation(info="<html>
<h4>Syntax</h4>
<blockquote><pre>
a = Components.<strong>deflectionAcceleration</strong>(torque, spring, spring_other, m_frame, I_frame, arm);
</pre></blockquote>
<h4>Limitations</h4>
<p>
The wheelsets follow a rail without irregularities and the car body rests on the frame with a constant force:
air springs are soft against the primary suspension. Angles are small.
</p>
</html>"));
end deflectionAcceleration;
