within RailBraking.Contact;
function fallingFriction "Friction at a slip speed"
  extends Icons.Function;
  input Types.Velocity slip_speed "Speed of the wheel over the rail";
  input Types.Ratio mu0 "Maximum friction coefficient";
  input Types.Ratio A "Friction at infinite slip speed over maximum friction";
  input Types.InverseVelocity B "Rate at which friction falls with slip speed";
  output Types.Ratio mu "Friction coefficient";
protected
  constant Types.Velocity w_small = 1e-3 "Rounding about zero slip speed";
  Types.Velocity w "Magnitude of the slip speed, rounded";
algorithm
  w := sqrt(slip_speed^2 + w_small^2) - w_small;
  mu := mu0*((1 - A)*exp(-B*w) + A);
  annotation (
    smoothOrder=100,
    Inline=true,
    Documentation(info="<html>
<p>
Polach (2005): mu0 at zero slip speed, A mu0 at high slip speed. It is an even function of the slip speed and smooth
everywhere.
</p>
<h4>Syntax</h4>
<blockquote><pre>
mu = Contact.<strong>fallingFriction</strong>(slip_speed, mu0, A, B);
</pre></blockquote>
<h4>Limitations</h4>
<p>The rounding reduces the slip speed by at most 1 mm/s, for B = 0.6 s/m less than 0.04 % of the friction.</p>
</html>"));
end fallingFriction;
