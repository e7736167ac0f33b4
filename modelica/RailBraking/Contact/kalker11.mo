within RailBraking.Contact;
function kalker11 "Kalker's coefficient of longitudinal creepage"
  input Types.Ratio ratio "Semi-axis along the track over semi-axis across";
  output Types.Ratio c11 "Kalker's coefficient";
algorithm
  c11 := 3.1190 + ratio*(0.99604 - 0.0018374*ratio);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Ellipse(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-90, 90}, {90, -90}}, textString="f", textColor={0, 0, 127}),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Documentation(info="<html>
<p>
Parabola through Kalker's table for Poisson's ratio 0.25 (Kalker, Three-dimensional Elastic Bodies in Rolling
Contact, 1990), fitted by least squares to its eleven entries from a/b = 0.5 to 2; the largest deviation is 0.17 %.
</p>
<h4>Syntax</h4>
<blockquote><pre>
c11 = Contact.<strong>kalker11</strong>(a/b);
</pre></blockquote>
<h4>Limitations</h4>
<p>Valid for a/b from 0.5 to 2. At Poisson's ratio 0.28 of steel the table is about 1 % higher.</p>
<h4>Notes</h4>
<p>
The polynomial 0.32955 (a/b)<sup>2</sup> + 0.48538 a/b + 3.4992 that circulates in simulators gives 4.31 for a circle,
where the table has 4.12.
</p>
</html>"));
end kalker11;
