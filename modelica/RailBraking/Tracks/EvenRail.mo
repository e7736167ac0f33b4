within RailBraking.Tracks;
block EvenRail "Rail without irregularities"
  extends Icons.Component;
  extends Interfaces.PartialRail;
equation
  height = fill(0, n);
  rate = fill(0, n);
  acceleration = fill(0, n);
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>The wheelsets stay at their height.</p>
<h4>Limitations</h4>
<p>None.</p>
</html>"));
end EvenRail;
