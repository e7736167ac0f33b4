within RailBraking.Vehicles;
function groupLoad "Load of a group of wheelsets on the rail"
  extends Icons.Function;
  input Types.Force static "Static load of the group";
  input Types.Force spring[:] "Spring and damper force over each wheelset of bogies, change from static";
  input Integer group_of_wheelset[size(spring, 1)] "Group of each of these wheelsets";
  input Integer group "Number of the group";
  output Types.Force load "Its load";
algorithm
  load := static + sum(if group_of_wheelset[i] == group then spring[i] else 0 for i in 1:size(spring, 1));
  annotation (
    Inline=true,
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Text(extent={{-90, 90}, {90, -90}}, textString="f", textColor={0, 0, 127})}),
    Documentation(info="<html>
<h4>Syntax</h4>
<blockquote><pre>
load = Vehicles.<strong>groupLoad</strong>(static, spring, group_of_wheelset, group);
</pre></blockquote>
<h4>Limitations</h4>
<p>A group without any of these wheelsets has its static load.</p>
</html>"));
end groupLoad;
