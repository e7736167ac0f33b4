within RailBraking.Contact;
function creepFactor "Slope of Polach's epsilon over slip, times friction and the cube root of the load"
  extends Icons.Function;
  input Types.Length r "Rolling radius of the wheel";
  input Types.Length r_rail "Radius of the rail head across the track";
  input Types.Modulus E "Young's modulus of wheel and rail";
  input Types.Ratio nu "Poisson's ratio of wheel and rail";
  output Real factor "epsilon*mu*Q^(1/3)/slip, in N^(1/3)";
protected
  constant Types.Force Q = 1e5 "Load at which the ellipse is computed; the result does not depend on it";
  Types.Length a "Semi-axis along the track";
  Types.Length b "Semi-axis across the track";
algorithm
  (a, b) := hertz(Q, r, r_rail, E, nu);
  factor := E/(2*(1 + nu))*3.14159265358979*a*b*kalker11(a/b)/(4*Q^(2/3));
  annotation (
    Documentation(info="<html>
<p>
All factors of &epsilon; that are constant during a simulation. The slope of the force at small slip is
2/&pi; (k_A + k_S) Q<sup>2/3</sup> <code>factor</code> for each wheel, independent of the friction.
</p>
<h4>Syntax</h4>
<blockquote><pre>
factor = Contact.<strong>creepFactor</strong>(r, r_rail, E, nu);
</pre></blockquote>
<h4>Limitations</h4>
<p>Those of <code>hertz</code> and <code>kalker11</code>. The cube root of a newton has no unit string.</p>
</html>"));
end creepFactor;
