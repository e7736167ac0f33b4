within RailBraking.Contact;
package Surfaces "Named parameter sets, each with its source"
  annotation (Documentation(info="<html>
<p>
At 80 km/h the adhesion of a wheel that carries 68.7 kN peaks at a slip of 2.5 % (Dry), 6.8 % (Wet), 3.0 %
(LowAdhesion),
9.5 % (BroadSoap) or 15.6 % (BroadLeaf): below, inside and above the 10 % to 15 % at which a slip controller works.
</p>
</html>"));
end Surfaces;
