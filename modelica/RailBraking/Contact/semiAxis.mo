within RailBraking.Contact;
function semiAxis "Semi-axis along the track, over the cube root of the load"
  extends Icons.Function;
  input Types.Length r "Rolling radius of the wheel";
  input Types.Length r_rail "Radius of the rail head across the track";
  input Types.Modulus E "Young's modulus of wheel and rail";
  input Types.Ratio nu "Poisson's ratio of wheel and rail";
  output Real a1 "a/Q^(1/3), in m/N^(1/3)";
protected
  constant Types.Force Q = 1e5 "Load at which the ellipse is computed; the result does not depend on it";
  Types.Length a "Semi-axis along the track";
  Types.Length b "Semi-axis across the track";
algorithm
  (a, b) := hertz(Q, r, r_rail, E, nu);
  a1 := a/Q^(1/3);
  annotation (
    Documentation(info="<html>
<p>The part of <a href=\"modelica://RailBraking.Contact.hertz\">hertz</a> that does not change while a train runs.</p>
<h4>Syntax</h4>
<blockquote><pre>
a1 = Contact.<strong>semiAxis</strong>(r, r_rail, E, nu);
</pre></blockquote>
<h4>Limitations</h4>
<p>Those of <code>hertz</code>. The cube root of a newton has no unit string.</p>
</html>"));
end semiAxis;
