within RailBraking.Tracks;
function gradientForce "Force of a gradient, forward"
  extends Icons.Function;
  input Types.Mass m "Mass of the train";
  input Types.Ratio gradient "Rise over length along the horizontal, positive uphill";
  output Types.Force F "Force on the train, forward";
algorithm
  F := -m*g*gradient/sqrt(1 + gradient^2);
  annotation (
    smoothOrder=100,
    Inline=true,
    Documentation(info="<html>
<p>m g sin(&beta;) with tan(&beta;) = gradient.</p>
<h4>Syntax</h4>
<blockquote><pre>
F = Tracks.<strong>gradientForce</strong>(m, gradient);
</pre></blockquote>
<h4>Limitations</h4>
<p>The train is a point; the load of the wheels is that on level track.</p>
</html>"));
end gradientForce;
