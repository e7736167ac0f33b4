within RailBraking.Contact;
function kalker11 "Kalker's coefficient of longitudinal creepage"
  extends Icons.Function;
  input Types.Ratio ratio "Semi-axis along the track over semi-axis across";
  output Types.Ratio c11 "Kalker's coefficient";
algorithm
  c11 := 3.1190 + ratio*(0.99604 - 0.0018374*ratio);
  annotation (
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
