within RailBraking;
package Tracks "Forces of gradients and curves"
  annotation (Documentation(info="<html>
<p>
Functions that turn a gradient or a curve into a force on the train, and blocks that do so along a track. A plant
takes the sum as its input <code>track_force</code>, forward positive.
</p>
</html>"));
end Tracks;
