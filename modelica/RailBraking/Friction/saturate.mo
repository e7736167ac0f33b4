within RailBraking.Friction;
function saturate "A number kept between -1 and 1, with rounded corners"
  input Types.Ratio x "Number";
  input Types.Ratio width = 0.1 "Width of the corners";
  output Types.Ratio y "Number between -1 and 1";
algorithm
  y := (sqrt((x + 1)^2 + width^2) - sqrt((x - 1)^2 + width^2))/2;
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
y = Friction.<strong>saturate</strong>(x, width);
</pre></blockquote>
<h4>Limitations</h4>
<p>At a corner the result is width/2 short of one; at x = 0 its slope is width<sup>2</sup>/2 short of one.</p>
</html>"));
end saturate;
