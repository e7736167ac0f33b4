within RailBraking.Interfaces;
partial block PartialTrack "What the track does to a train at a place"
  parameter Types.Mass m(start=84000) "Mass of the train";
  RealInput distance(final unit="m") "Distance travelled"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  RealOutput track_force(final unit="N") "Force of gradient and curve, forward"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>The train counts as a point.</p>
</html>"));
end PartialTrack;
