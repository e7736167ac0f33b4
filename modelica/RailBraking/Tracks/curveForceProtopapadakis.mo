within RailBraking.Tracks;
function curveForceProtopapadakis "Force of a curve, forward, after Protopapadakis"
  extends Icons.Function;
  input Types.Mass m "Mass of the train";
  input Types.Curvature curvature "Curvature of the track";
  input Types.Length wheelbase "Wheelbase of the bogies";
  input Types.Length gauge = 1.435 "Track gauge";
  output Types.Force F "Force on the train, forward; never positive";
algorithm
  F := -m*g*sqrt(curvature^2 + 1e-12)*(0.158*gauge + 0.103*wheelbase);
  annotation (
    smoothOrder=100,
    Inline=true,
    Documentation(info="<html>
<p>With a friction of 0.22 between wheel and rail.</p>
<h4>Syntax</h4>
<blockquote><pre>
F = Tracks.<strong>curveForceProtopapadakis</strong>(m, curvature, wheelbase, gauge);
</pre></blockquote>
<h4>Limitations</h4>
<p>Quoted from secondary sources. The magnitude of the curvature is rounded below 1e-6 1/m.</p>
</html>"));
end curveForceProtopapadakis;
