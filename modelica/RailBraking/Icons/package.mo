within RailBraking;
package Icons "What classes of one kind look like"
  annotation (Documentation(info="<html>
<p>
Classes extend the icon of their kind and draw only what tells them from others. Icons have no equations.
</p>
</html>"));
end Icons;
