within RailBraking.Tracks;
block UniformTrack "Track of constant gradient and curvature after a position"
  extends Icons.Component;
  extends Interfaces.PartialTrack;
  parameter Types.Ratio gradient = 0 "Rise over length, positive uphill";
  parameter Types.Curvature curvature = 0 "Curvature";
  parameter Types.Length wheelbase = 1.9 "Wheelbase of the bogies";
  parameter Types.Length begin = 0 "Distance at which gradient and curve begin";
  parameter Types.Length transition(min=1) = 20 "Length over which they begin";
protected
  Types.Ratio share "Effective share of gradient and curve";
equation
  share = (1 + tanh(4*(distance - begin)/transition))/2;
  track_force = share*(gradientForce(m, gradient) + curveForce(m, curvature, wheelbase));
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Gradient and curve begin together around <code>begin</code>, with a smooth transition that represents the length of the
train.
</p>
<h4>Limitations</h4>
<p>One change; for a surveyed line, sum the functions of this package outside and use the input
<code>track_force</code>.</p>
</html>"));
end UniformTrack;
