within RailBraking.Pneumatics;
function orificeFlow "Free air through an orifice"
  extends Icons.Function;
  input Real C(final unit="m3/(s.Pa)") "Sonic conductance: free air a second for a pascal of absolute pressure";
  input Types.Pressure p_a "Pressure on one side, above the atmosphere";
  input Types.Pressure p_b "Pressure on the other side, above the atmosphere";
  output Types.VolumeFlow q "Free air from a to b";
protected
  Types.Pressure p_high "Higher absolute pressure";
  Types.Pressure p_low "Lower absolute pressure";
  Types.Pressure dp "Difference, positive from a to b";
algorithm
  p_high := max(p_a, p_b) + p_free;
  p_low := max(min(p_a, p_b) + p_free, 1);
  dp := p_a - p_b;
  q := C*(if 2*p_low > p_high then 2*sqrt(p_low)*dp/sqrt(sqrt(dp^2 + 1e4)) elseif dp > 0 then p_high else -p_high);
  annotation (
    Inline=true,
    Documentation(info="<html>
<h4>Syntax</h4>
<blockquote><pre>
q = Pneumatics.<strong>orificeFlow</strong>(C, p_a, p_b);
</pre></blockquote>
<p>
ISO 6358 with a critical ratio b of one half (an ideal nozzle has 0.528): choked, q = C p<sub>high</sub>, where the
lower absolute
pressure is at most half of the higher one, and
</p>
<blockquote><pre>
q = C p_high sqrt(1 - ((r - b)/(1 - b))^2) = 2 C sqrt((p_high - p_low) p_low),   r = p_low/p_high
</pre></blockquote>
<p>
above. An effective area of 1 mm&sup2; has about 2e-9 m&sup3;/(s Pa).
</p>
<h4>Limitations</h4>
<p>Below 1 mbar the square root is rounded, so that its slope is finite where the flow reverses.</p>
</html>"));
end orificeFlow;
