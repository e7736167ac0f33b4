within RailBraking.Pneumatics;
function delayWeights "Weights of the values of a delay line, for linear interpolation"
  extends Icons.Function;
  input Real delay "Delay over the sampling period";
  input Integer n "Number of stored values, the newest first";
  output Real weight[n] "Weight of each value";
algorithm
  weight := {max(0, 1 - abs(delay - i + 1)) for i in 1:n};
  annotation (Documentation(info="<html>
<p>
The value at a delay between those of two samples is <code>delayWeights(delay, n)*line</code>.
</p>
<h4>Limitations</h4>
<p>Beyond <code>n</code> the weights are zero.</p>
</html>"));
end delayWeights;
