within RailBraking.Contact;
function hertz "Semi-axes of the contact ellipse of a conical wheel on a rail head"
  extends Icons.Function;
  input Types.Force Q "Load of the wheel";
  input Types.Length r "Rolling radius of the wheel";
  input Types.Length r_rail "Radius of the rail head across the track";
  input Types.Modulus E "Young's modulus of wheel and rail";
  input Types.Ratio nu "Poisson's ratio of wheel and rail";
  output Types.Length a "Semi-axis along the track";
  output Types.Length b "Semi-axis across the track";
protected
  Types.Modulus E_effective "Contact modulus of two equal bodies";
  Types.Length r_effective "Radius of the sphere with a contact of the same area";
  Types.Length c "Geometric mean of the semi-axes";
  Types.Ratio ratio "a/b";
algorithm
  E_effective := E/(2*(1 - nu^2));
  r_effective := (16*r*r_rail/(1/r + 1/r_rail))^(1/3)/2;
  c := (3*Q*r_effective/(4*E_effective))^(1/3);
  ratio := (r/r_rail)^(2/3);
  a := c*sqrt(ratio);
  b := c/sqrt(ratio);
  annotation (
    Documentation(info="<html>
<p>
Greenwood's approximation (Tribology International 30, 1997) of Hertz's solution with elliptic integrals: with the
relative
curvatures A = 1/(2 r) and B = 1/(2 r_rail) the contact has the area of that of a sphere of radius
</p>
<blockquote><pre>
r_effective = 1/2 (A B (A + B)/2)^(-1/3),   a/b = (B/A)^(2/3)
</pre></blockquote>
<h4>Syntax</h4>
<blockquote><pre>
(a, b) = Contact.<strong>hertz</strong>(Q, r, r_rail, E, nu);
</pre></blockquote>
<h4>Limitations</h4>
<p>
Within 0.1 % in the mean semi-axis and 0.5 % in the ratio for a/b from 0.5 to 2. The profile of the
wheel is assumed to be straight across the track, and the rail straight along it.
</p>
</html>"));
end hertz;
