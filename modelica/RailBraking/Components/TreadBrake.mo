within RailBraking.Components;
model TreadBrake "Brake units of one group with blocks on the tread"
  extends Icons.Component;
  extends GroupBrake(redeclare Friction.BlockFriction pad);
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>A <a href=\"modelica://RailBraking.Components.GroupBrake\">GroupBrake</a> with blocks; the wheel is its disc.</p>
<h4>Limitations</h4>
<p>The wheel has the thermal data of a disc, which do not act on the friction of blocks.</p>
</html>"));
end TreadBrake;
