within RailBraking.Interfaces;
partial block PartialTrack "What the track does to a train at a place"
  parameter Types.Mass m(start=84000) "Mass of the train";
  RealInput distance(final unit="m") "Distance travelled";
  RealOutput track_force(final unit="N") "Force of gradient and curve, forward";
  annotation (Documentation(info="<html>
<p>The train counts as a point.</p>
</html>"));
end PartialTrack;
