within RailBraking.Contact;
function polach "Adhesion of a wheel at a slip"
  extends Icons.Function;
  input Types.Ratio slip "Slip, 0 rolling, 1 locked";
  input Types.Velocity slip_speed "Speed of the wheel over the rail";
  input Types.Force Q "Load of the wheel";
  input Types.Ratio mu0 "Maximum friction coefficient";
  input Real factor "Result of creepFactor";
  input Types.Ratio k_A "Reduction in the area of adhesion";
  input Types.Ratio k_S "Reduction in the area of slip";
  input Types.Ratio A "Friction at infinite slip speed over maximum friction";
  input Types.InverseVelocity B "Rate at which friction falls with slip speed";
  output Types.Ratio alpha "Force over load, with the sign of the slip";
protected
  constant Types.Ratio mu_small = 1e-9 "Keeps epsilon finite at zero friction";
  Types.Ratio mu "Friction at this slip speed";
  Types.Ratio epsilon "Gradient of the tangential stress";
algorithm
  mu := fallingFriction(slip_speed, mu0, A, B);
  epsilon := factor*slip/((mu + mu_small)*Q^(1/3));
  alpha := 2*mu/3.14159265358979*(k_A*epsilon/(1 + (k_A*epsilon)^2) + atan(k_S*epsilon));
  annotation (
    smoothOrder=100,
    Inline=true,
    Documentation(info="<html>
<p>Polach (2005), Wear 258, pages 992 to 1000, without lateral creepage and spin. Odd in slip and smooth everywhere.</p>
<h4>Syntax</h4>
<blockquote><pre>
alpha = Contact.<strong>polach</strong>(slip, slip_speed, Q, mu0, factor, k_A, k_S, A, B);
</pre></blockquote>
<h4>Limitations</h4>
<p>
The load must be positive. Friction depends on the slip speed alone: neither the cleaning of the rail by slip nor the
temperature of the contact is modelled; a scenario expresses cleaning by <code>mu0</code>, and
<a href=\"modelica://RailBraking.Contact.HeatedContact\">HeatedContact</a> gives it a warm friction.
</p>
</html>"));
end polach;
