within RailBraking.Pneumatics;
function delayWeights "Weights of the values of a delay line, for linear interpolation"
  extends Icons.Function;
  input Types.Ratio delay "Delay over the sampling period";
  input Integer n "Number of stored values, the newest first";
  output Types.Ratio weight[n] "Weight of each value";
algorithm
  weight := {max(0, 1 - abs(delay - i + 1)) for i in 1:n};
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<blockquote><pre>
weight = Pneumatics.<strong>delayWeights</strong>(delay, n);
</pre></blockquote>
<p>
The value of a delay line between two samples is <code>weight*line</code>, interpolated linearly.
</p>
<h4>Limitations</h4>
<p>Beyond <code>n</code> the weights are zero.</p>
</html>"));
end delayWeights;
