within RailBraking.Predictions;
block LateralPrediction "Lateral dynamics with unknown friction, on a track whose position is known"
  extends Icons.Vehicle;
  extends Vehicles.PartialLateralPrediction;
  Interfaces.RealInput track(final unit="m", start=0) "Lateral position of the middle of the track"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
equation
  displacement = y - track;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>Five states: y, dy, psi, dpsi, log_mu0, in this order.</p>
<h4>Limitations</h4>
<p>
A vehicle seldom knows its track to fractions of a millimetre; see <a
href=\"modelica://RailBraking.Predictions.LateralPredictionUnknownTrack\">LateralPredictionUnknownTrack</a>.
Otherwise those
of <a href=\"modelica://RailBraking.Vehicles.PartialLateralPrediction\">PartialLateralPrediction</a>.
</p>
</html>"));
end LateralPrediction;
