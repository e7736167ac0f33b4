within RailBraking.Components;
function bearingFriction "Resistance of the axle bearings divided by load"
  extends Icons.Function;
  input Types.Ratio mu_bearing "Friction coefficient of the bearings";
  input Types.Length r_bearing "Radius of the bearings";
  input Types.Length r_wheel "Rolling radius of the wheels";
  output Types.Ratio f "Resisting force at the rim divided by load";
algorithm
  f := 1/sqrt((r_wheel/(mu_bearing*r_bearing))^2*(1 + mu_bearing^2) - 1);
  annotation (
    Documentation(info="<html>
<p>Schwarz, L&uuml;dicke and Heckmann (2019), equation (5); about mu_bearing r_bearing/r_wheel.</p>
<h4>Syntax</h4>
<blockquote><pre>
f = Components.<strong>bearingFriction</strong>(mu_bearing, r_bearing, r_wheel);
</pre></blockquote>
<h4>Limitations</h4>
<p><code>mu_bearing</code> and <code>r_bearing</code> must be positive. The larger resistance when starting from rest
is not modelled.</p>
</html>"));
end bearingFriction;
