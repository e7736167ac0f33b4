within RailBraking.Friction;
function relaxation "Rate of a pad friction that relaxes towards a rest value, faster at lower friction"
  extends Icons.Function;
  input Types.Ratio mu "Pad friction";
  input Types.Ratio mu_rest "Pad friction at rest";
  input Types.Time T "Time constant, times pad friction";
  output Real rate(final unit="1/s") "Rate of pad friction";
protected
  constant Types.Ratio mu_floor = 0.05 "Pad friction below which the rate rises no further";
  constant Types.Ratio mu_small = 1e-3 "Rounding about mu_small";
algorithm
  rate := (mu_rest - mu)/(T*(mu_floor + Pneumatics.positivePart(mu - mu_floor, mu_small)));
  annotation (
    smoothOrder=100,
    Inline=true,
    Documentation(info="<html>
<p>
Equation (9) of Schwarz and Keck (2020), (mu_rest - mu)/(T mu), after Ostermeyer. As printed it is
singular at mu = 0, which a filter's mean may cross: below 0.05, outside the range of working pads,
the denominator is that of 0.05.
</p>
<h4>Syntax</h4>
<blockquote><pre>
rate = Friction.<strong>relaxation</strong>(mu, mu_rest, T);
</pre></blockquote>
<h4>Limitations</h4>
<p>The rounding changes the rate by less than 1e-5 of itself at the friction of a working pad.</p>
</html>"));
end relaxation;
