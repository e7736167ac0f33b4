within RailBraking.Predictions;
block LateralPredictionUnknownTrack
  "Lateral dynamics with unknown friction, on a track of which only the spectrum is known"
  extends Icons.Vehicle;
  extends Vehicles.PartialLateralPrediction;
  parameter Types.Frequency track_frequency = 2 "Corner frequency of the track irregularity at the present speed";
  parameter Types.Ratio track_damping = 0.70710678118654752 "Damping of the irregularity's low-pass";
  Types.Length track(start=0, fixed=true, nominal=1e-3, stateSelect=StateSelect.always)
    "Lateral position of the middle of the track";
  Types.Velocity track_rate(start=0, fixed=true, nominal=1e-2, stateSelect=StateSelect.always)
    "Derivative of the lateral position of the track";
protected
  final parameter Types.AngularVelocity w_track = 2*3.14159265358979*track_frequency "Corner of the low-pass";
equation
  displacement = y - track;
  der(track) = track_rate;
  der(track_rate) = -w_track^2*track - 2*track_damping*w_track*track_rate;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Seven states: y, dy, psi, dpsi, log_mu0, track, track_rate, in this order. The irregularity is white noise through a
low-pass of second order; the noise enters as process noise of <code>track_rate</code>.
</p>
<h4>Limitations</h4>
<p>
Readings determine <code>y - track</code>, but hardly either of the two alone. Otherwise those of <a
href=\"modelica://RailBraking.Vehicles.PartialLateralPrediction\">PartialLateralPrediction</a>.
</p>
</html>"));
end LateralPredictionUnknownTrack;
