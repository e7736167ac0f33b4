within RailBraking.Contact;
function polachSlopes "Derivatives of the creep force of a wheel at a given friction"
  extends Icons.Function;
  input Types.Ratio creep "Total creep";
  input Types.Ratio friction "Friction coefficient at the present creep speed, positive";
  input Types.Force Q "Load of the wheel";
  input Real factor "Result of creepFactor";
  input Types.Ratio k_A "Reduction in the area of adhesion";
  input Types.Ratio k_S "Reduction in the area of slip";
  output Types.Force by_creep "Derivative with respect to creep at constant friction";
  output Types.Force by_friction "Derivative with respect to friction at constant creep";
protected
  Types.Ratio epsilon "Gradient of the tangential stress";
  Types.Ratio E "Share of the area of adhesion";
  Types.Ratio S "Share of the area of slip";
  Types.Ratio slope "Derivative of both terms with respect to epsilon";
algorithm
  epsilon := factor*creep/(friction*Q^(1/3));
  E := k_A*epsilon;
  S := k_S*epsilon;
  slope := k_A*(1 - E^2)/(1 + E^2)^2 + k_S/(1 + S^2);
  by_creep := 2*Q/3.14159265358979*factor/Q^(1/3)*slope;
  by_friction := 2*Q/3.14159265358979*(E/(1 + E^2) + atan(S) - epsilon*slope);
  annotation (
    smoothOrder=100,
    Inline=true,
    Documentation(info="<html>
<p>
Both partial derivatives of <a href=\"modelica://RailBraking.Contact.polach\">polach</a> times the load, for a filter
that integrates force and friction instead of computing them.
</p>
<h4>Syntax</h4>
<blockquote><pre>
(by_creep, by_friction) = Contact.<strong>polachSlopes</strong>(creep, friction, Q, factor, k_A, k_S);
</pre></blockquote>
<h4>Notes</h4>
<p>At small creep <code>by_friction</code> is of third order in &epsilon;: the force hardly depends on friction.</p>
<h4>Limitations</h4>
<p>Those of <code>polach</code>; the friction must not approach zero.</p>
</html>"));
end polachSlopes;
