within RailBraking.Tracks;
function curveForce "Force of a curve, forward, after Schwarz and others"
  extends Icons.Function;
  input Types.Mass m "Mass of the train";
  input Types.Curvature curvature "Curvature of the track";
  input Types.Length wheelbase "Wheelbase of the bogies";
  input Types.Length gauge = 1.435 "Track gauge";
  output Types.Force F "Force on the train, forward; never positive";
algorithm
  F := -m*g*sqrt(curvature^2 + 1e-12)*(0.158*wheelbase + 0.033*gauge);
  annotation (
    smoothOrder=100,
    Inline=true,
    Documentation(info="<html>
<p>Schwarz, L&uuml;dicke and Heckmann (2019), equation (7), as printed: 0.70 per mille at a radius of 500 m and a
wheelbase of 1.9 m.</p>
<h4>Syntax</h4>
<blockquote><pre>
F = Tracks.<strong>curveForce</strong>(m, curvature, wheelbase, gauge);
</pre></blockquote>
<h4>Limitations</h4>
<p>
The coefficients differ from the formula of Protopapadakis, which they resemble, and give half the resistance of
R&ouml;ckl: see
<a href=\"modelica://RailBraking.Tracks.curveForceProtopapadakis\">curveForceProtopapadakis</a> and
<a href=\"modelica://RailBraking.Tracks.curveForceRoeckl\">curveForceRoeckl</a>. The magnitude of the curvature is
rounded below 1e-6 1/m.
</p>
</html>"));
end curveForce;
