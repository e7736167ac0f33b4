within RailBraking.Friction;
function saturate "A number limited to -1 and 1, with rounded corners"
  extends Icons.Function;
  input Types.Ratio x "Number";
  input Types.Ratio width = 0.1 "Width of the corners";
  output Types.Ratio y "Number between -1 and 1";
algorithm
  y := (sqrt((x + 1)^2 + width^2) - sqrt((x - 1)^2 + width^2))/2;
  annotation (
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
