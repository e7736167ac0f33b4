within RailBraking.Pneumatics;
function positivePart "A number or zero, whichever is larger, with a rounded corner"
  input Real x "Number";
  input Real x_small "Width of the corner, in the unit of x, positive";
  output Real y "Positive number";
algorithm
  y := (x + sqrt(x^2 + x_small^2))/2;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Ellipse(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-90, 90}, {90, -90}}, textString="f", textColor={0, 0, 127}),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
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
