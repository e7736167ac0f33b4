within RailBraking.Pneumatics;
function positivePart "A number or zero, whichever is larger, with a rounded corner"
  extends Icons.Function;
  input Real x "Number";
  input Real x_small "Width of the corner, in the unit of x, positive";
  output Real y "Positive number";
algorithm
  y := (x + sqrt(x^2 + x_small^2))/2;
  annotation (
    smoothOrder=100,
    Inline=true,
    Documentation(info="<html>
<h4>Syntax</h4>
<blockquote><pre>
y = Pneumatics.<strong>positivePart</strong>(x, x_small);
</pre></blockquote>
<h4>Limitations</h4>
<p>Exceeds the sharp result by x_small/2 at the corner and by x_small<sup>2</sup>/(4 |x|) far from it.</p>
</html>"));
end positivePart;
