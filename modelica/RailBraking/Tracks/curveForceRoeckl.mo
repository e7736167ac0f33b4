within RailBraking.Tracks;
function curveForceRoeckl "Force of a curve, forward, after Roeckl"
  input Types.Mass m "Mass of the train";
  input Types.Length radius "Radius of the curve, at least 300 m";
  output Types.Force F "Force on the train, forward; never positive";
algorithm
  assert(radius >= 300, "Tracks.curveForceRoeckl: valid for a radius of 300 m and more, got " + String(radius) + " m.");
  F := -m*g*0.650/(radius - 55);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Ellipse(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-90, 90}, {90, -90}}, textString="f", textColor={0, 0, 127}),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
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
