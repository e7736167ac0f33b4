within RailBraking.Tracks;
function curveForceRoeckl "Force of a curve, forward, after Roeckl"
  extends Icons.Function;
  input Types.Mass m "Mass of the train";
  input Types.Length radius "Radius of the curve, at least 300 m";
  output Types.Force F "Force on the train, forward; never positive";
algorithm
  assert(radius >= 300, "Tracks.curveForceRoeckl: valid for a radius of 300 m and more, got " + String(radius) + " m.");
  F := -m*g*0.650/(radius - 55);
  annotation (
    Documentation(info="<html>
<p>650/(R - 55) per mille of the weight for main lines, R in metres.</p>
<h4>Syntax</h4>
<blockquote><pre>
F = Tracks.<strong>curveForceRoeckl</strong>(m, radius);
</pre></blockquote>
<h4>Limitations</h4>
<p>A mean of old freight stock; radii of 300 m and more.</p>
</html>"));
end curveForceRoeckl;
