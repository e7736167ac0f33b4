within RailBraking.Interfaces;
partial block PartialTrack "Force of the track on a train at a position"
  extends Icons.Component;
  parameter Types.Mass m(start=84000) "Mass of the train";
  RealInput distance(final unit="m") "Distance travelled"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  RealOutput track_force(final unit="N") "Force of gradient and curve, forward"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>The train is a point.</p>
</html>"));
end PartialTrack;
