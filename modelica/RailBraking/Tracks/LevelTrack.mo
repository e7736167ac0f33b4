within RailBraking.Tracks;
block LevelTrack "Straight level track"
  extends Icons.Component;
  extends Interfaces.PartialTrack;
equation
  track_force = 0;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>Track without any force.</p>
<h4>Limitations</h4>
<p>None.</p>
</html>"));
end LevelTrack;
