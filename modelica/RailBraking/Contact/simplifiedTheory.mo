within RailBraking.Contact;
function simplifiedTheory "Adhesion of a wheel at a slip by Kalker's simplified theory"
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
  constant Types.Ratio epsilon_small = 1e-6 "Rounding of the magnitude of epsilon about zero";
  constant Types.Ratio hardening = 0.7 "Rate at which the creep stiffness falls with epsilon";
  constant Real pi = 3.14159265358979 "Ratio of a circle's circumference to its diameter";
  Types.Ratio mu "Friction at this slip speed";
  Types.Ratio epsilon "Gradient of the tangential stress of bare steel";
  Types.Ratio magnitude "Its magnitude, rounded";
  Types.Ratio h "Gradient of the stress over the one at which the whole contact slides";
  Types.Angle theta "Strips nearer to the middle than b*sin(theta) adhere at their leading edges";
  Real loss "Integral of (cos(x) - h)^3*cos(x) over x from 0 to theta";
algorithm
  mu := fallingFriction(slip_speed, mu0, A, B);
  epsilon := factor*slip/((mu + mu_small)*Q^(1/3));
  magnitude := sqrt(epsilon^2 + epsilon_small^2);
  h := min(3/8*magnitude*(k_S + (k_A - k_S)/2/(1 + hardening*magnitude)), 1 - 1e-9);
  theta := acos(h);
  loss := 3*theta/8 + sin(2*theta)/4 + sin(4*theta)/32 - 3*h*(sin(theta) - sin(theta)^3/3)
    + 3*h^2*(theta/2 + sin(2*theta)/4) - h^3*sin(theta);
  alpha := mu*(1 - 16/(3*pi)*loss)*epsilon/magnitude;
  annotation (
    smoothOrder=1,
    Inline=true,
    Documentation(info="<html>
<p>
Kalker, Vehicle System Dynamics 11 (1982) 1 (FASTSIM), for longitudinal creepage alone, where each strip of the contact
has a closed form: with the stress s x behind the leading edge, s = G c11 3 slip/(8 a), and the limit
&kappa; x (2 c - x) of a strip of half length c, the strip adheres over d = max(0, 2 c - s/&kappa;) and carries
&kappa; (4 c<sup>3</sup>/3 - d<sup>3</sup>/6). The integral over all strips of the ellipse is <code>loss</code>. The
creep stiffness falls with epsilon from Polach's, (k_A + k_S)/2, to k_S, in the form of Spiryagin, Polach and Cole,
Vehicle System Dynamics 51 (2013).
</p>
<h4>Syntax</h4>
<blockquote><pre>
alpha = Contact.<strong>simplifiedTheory</strong>(slip, slip_speed, Q, mu0, factor, k_A, k_S, A, B);
</pre></blockquote>
<h4>Limitations</h4>
<p>
The load must be positive. One friction holds in the whole contact. The value of <code>hardening</code> is an estimate
within the published range.
</p>
</html>"));
end simplifiedTheory;
