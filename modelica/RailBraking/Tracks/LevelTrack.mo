within RailBraking.Tracks;
block LevelTrack "Straight level track"
  extends Interfaces.PartialTrack;
equation
  track_force = 0;
  annotation (Documentation(info="<html>
<p>The track that does nothing.</p>
<h4>Limitations</h4>
<p>None.</p>
</html>"));
end LevelTrack;
