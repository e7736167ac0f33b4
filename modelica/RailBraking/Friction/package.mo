within RailBraking;
package Friction "Pads on discs: friction coefficient and temperature"
  annotation (Documentation(info="<html>
<p>
One friction coefficient and one disc represent all brake units of a group, because they have the same cylinder pressure
and speed.
</p>
</html>"));
end Friction;
