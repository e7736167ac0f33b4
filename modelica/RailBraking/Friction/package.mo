within RailBraking;
package Friction "Pads on discs: friction coefficient and temperature"
  annotation (Documentation(info="<html>
<p>
One friction coefficient and one disc stand for all brake units of a group: they share cylinder pressure and speed.
</p>
</html>"));
end Friction;
