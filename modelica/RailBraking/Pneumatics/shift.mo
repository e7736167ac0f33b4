within RailBraking.Pneumatics;
function shift "Delay line one period later"
  input Real newest "Sample that enters";
  input Real line[:] "Samples, newest first";
  output Real shifted[size(line, 1)] "Samples one period later; the oldest is lost";
algorithm
  shifted[1] := newest;
  for i in 2:size(line, 1) loop
    shifted[i] := line[i - 1];
  end for;
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<blockquote><pre>
shifted = Pneumatics.<strong>shift</strong>(newest, line);
</pre></blockquote>
<h4>Limitations</h4>
<p>The line must hold at least one sample.</p>
</html>"));
end shift;
