within RailBraking;
package Icons "Icons for each kind of class"
  annotation (Documentation(info="<html>
<p>
Classes extend the icon of their kind and draw only what distinguishes them from others. Icons have no equations.
</p>
</html>"));
end Icons;
