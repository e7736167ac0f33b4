within RailBraking.Tracks;
block LevelTrack "Straight level track"
  extends Interfaces.PartialTrack;
equation
  track_force = 0;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>The track that does nothing.</p>
<h4>Limitations</h4>
<p>None.</p>
</html>"));
end LevelTrack;
