within RailBraking;
package Contact "Longitudinal adhesion between wheel and rail after Polach, on Hertz's ellipse"
  annotation (Documentation(info="<html>
<p>
The creep force of Polach (2005) for one wheel that carries the load Q, without lateral creepage and spin:
</p>
<blockquote><pre>
&epsilon; = G &pi; a b c11/(4 Q &mu;) s
F = 2 Q &mu;/&pi; (k_A &epsilon;/(1 + (k_A &epsilon;)^2) + arctan(k_S &epsilon;))
&mu; = &mu;0 ((1 - A) exp(-B w) + A)
</pre></blockquote>
<p>
with the slip s, the slip speed w, the semi-axes a (along the rail) and b (across) of the contact, Kalker's
coefficient c11 and the shear modulus G. The semi-axes grow as Q<sup>1/3</sup>, therefore &epsilon; falls as
Q<sup>-1/3</sup>: <code>hertz</code> and <code>kalker11</code> run once, at initialisation, in <code>creepFactor</code>.
</p>
</html>"));
end Contact;
