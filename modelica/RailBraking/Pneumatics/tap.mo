within RailBraking.Pneumatics;
function tap "Value at a position of a delay line, interpolated"
  input Real line[:] "Samples, newest first";
  input Types.Ratio position "Position in periods, 0 for the newest sample";
  output Real y "Interpolated sample";
algorithm
  y := 0;
  for i in 1:size(line, 1) loop
    y := y + line[i]*max(0, 1 - abs(position + 1 - i));
  end for;
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<blockquote><pre>
y = Pneumatics.<strong>tap</strong>(line, position);
</pre></blockquote>
<h4>Limitations</h4>
<p>Zero beyond the end of the line.</p>
</html>"));
end tap;
