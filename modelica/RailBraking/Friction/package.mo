within RailBraking;
package Friction "Pads on discs and blocks on the tread: friction coefficient and temperature"
  annotation (Documentation(info="<html>
<p>
One friction coefficient and one disc represent all brake units of a group, because they have the same cylinder pressure
and speed.
</p>
</html>"));
end Friction;
