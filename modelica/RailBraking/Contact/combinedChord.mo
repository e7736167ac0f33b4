within RailBraking.Contact;
function combinedChord "Adhesion over creepage of a wheel with longitudinal and lateral creepage"
  extends Icons.Function;
  input Types.Ratio creep_x "Creepage along the track, positive when the wheel turns too slowly";
  input Types.Ratio creep_y "Creepage across the track";
  input Types.Velocity v "Speed of the wheelset, positive";
  input Types.Force Q "Load of the wheel, positive";
  input Types.Ratio mu0 "Maximum friction coefficient";
  input Real factor "Result of creepFactor";
  input Types.Ratio ratio "Kalker's c22 over c11";
  input Types.Ratio k_A "Reduction in the area of adhesion";
  input Types.Ratio k_S "Reduction in the area of slip";
  input Types.Ratio A "Friction at infinite slip speed over maximum friction";
  input Types.InverseVelocity B "Rate at which friction falls with slip speed";
  output Types.Ratio chord "Force over load and creepage, the same in every direction";
protected
  constant Types.Ratio creep_small = 1e-6 "Rounding of the total creepage about zero";
  Types.Ratio creep "Total creepage";
  Real factor_here "Factor in the direction of the creepage";
algorithm
  creep := sqrt(creep_x^2 + creep_y^2 + creep_small^2);
  factor_here := factor*sqrt(creep_x^2 + (ratio*creep_y)^2 + creep_small^2)/creep;
  chord := polach(creep, creep*v, Q, mu0, factor_here, k_A, k_S, A, B)/creep;
  annotation (
    smoothOrder=100,
    Inline=true,
    Documentation(info="<html>
<p>
Polach (2005) for both directions at once: the force points against the total creepage, its magnitude is that of
<a href=\"modelica://RailBraking.Contact.polach\">polach</a> with Kalker's coefficient
&radic;((c11 creep_x)<sup>2</sup> + (c22 creep_y)<sup>2</sup>)/creep. Smooth everywhere. The force along
the track is chord Q creep_x, across it chord Q creep_y, both against the creepage.
</p>
<h4>Syntax</h4>
<blockquote><pre>
chord = Contact.<strong>combinedChord</strong>(creep_x, creep_y, v, Q, mu0, factor, ratio, k_A, k_S, A, B);
</pre></blockquote>
<h4>Limitations</h4>
<p>Without spin. A total creepage below creep_small = 1e-6 is rounded; curves saturate a thousand times above it.</p>
</html>"));
end combinedChord;
