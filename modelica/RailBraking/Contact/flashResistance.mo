within RailBraking.Contact;
function flashResistance "Mean temperature rise of a contact over the heat flow into one of its bodies"
  extends Icons.Function;
  input Types.Length a "Semi-axis along the motion";
  input Types.Length b "Semi-axis across the motion";
  input Types.Velocity V "Speed at which the contact moves over the body, not negative";
  input Types.HeatConductivity k "Heat conductivity of the body";
  input Types.Density rho "Density of the body";
  input Types.SpecificHeat c_p "Specific heat capacity of the body";
  output Types.ThermalResistance resistance "Mean temperature rise over the contact, a heat flow";
protected
  constant Real pi = 3.14159265358979 "Circle's circumference over its diameter";
  Types.Ratio Peclet "Speed over that of the diffusion of heat across the contact";
algorithm
  Peclet := V*a*rho*c_p/(2*k);
  resistance := 1.2204*a/(k*sqrt(pi*(0.658 + Peclet)))/(pi*a*b);
  annotation (
    smoothOrder=100,
    Inline=true,
    Documentation(info="<html>
<p>
Steady temperature of a half-space under an ellipse of uniform heat that moves over it. The form is that of Tian and
Kennedy (Journal of Tribology 116 (1994) 167); the two numbers follow from closed forms of its ends:
</p>
<ul>
<li>Fast motion: each strip along the motion is a band of the length L, under which temperature rises as
2 q &radic;(x/(&pi; k rho c_p V)), to 2 q &radic;(L/(&pi; k rho c_p V)) at its rear edge (Jaeger 1942; Ertz and Knothe,
Wear 253 (2002) 498). The mean over the ellipse is B(1/2, 7/4)/(3 &pi;/8) = 0.9153 times 2/3 of that of the longest
strip, L = 2 a, where B is the beta function.</li>
<li>At rest: the mean over a circle is 8 q a/(3 &pi; k) (Carslaw and Jaeger, Conduction of Heat in Solids).</li>
</ul>
<h4>Syntax</h4>
<blockquote><pre>
resistance = Contact.<strong>flashResistance</strong>(a, b, V, k, rho, c_p);
</pre></blockquote>
<h4>Limitations</h4>
<p>
Heat is uniform over the ellipse; by the pressure of Hertz it is greater in the middle. At rest the body is large and
has had time to become steady, and a/b is near 1. The temperature of single asperities, some hundred kelvin above the
mean, is not in it.
</p>
</html>"));
end flashResistance;
