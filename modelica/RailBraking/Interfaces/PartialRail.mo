within RailBraking.Interfaces;
partial block PartialRail "Vertical motion of the wheelsets of a bogie, which follow the rail"
  extends Icons.Component;
  parameter Integer n(min=1) = 2 "Number of wheelsets" annotation(Evaluate=true);
  parameter Types.Length behind[n] = fill(0, n) "Distance of each wheelset behind the leading one of the train";
  RealInput v(final unit="m/s") "Speed along the track"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  RealOutput height[n](each final unit="m") "Height of each wheelset over its height on an even rail"
    annotation(Placement(transformation(extent={{100, 50}, {120, 70}})));
  RealOutput rate[n](each final unit="m/s") "Upward speed of each wheelset"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  RealOutput acceleration[n](each final unit="m/s2") "Upward acceleration of each wheelset"
    annotation(Placement(transformation(extent={{100, -70}, {120, -50}})));
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>The wheelsets do not leave the rail, and the rail does not yield.</p>
</html>"));
end PartialRail;
