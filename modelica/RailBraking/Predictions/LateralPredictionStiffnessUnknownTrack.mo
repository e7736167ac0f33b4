within RailBraking.Predictions;
block LateralPredictionStiffnessUnknownTrack
  "Lateral dynamics with unknown friction and creep stiffness, on a track of which only the spectrum is known"
  extends LateralPredictionUnknownTrack(stiffness=exp(log_stiffness));
  Real log_stiffness(final unit="1", start=0, fixed=true, nominal=1, stateSelect=StateSelect.always)
    "Natural logarithm of the creep stiffness over that of k_A and k_S";
equation
  der(log_stiffness) = 0;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Eight states: track, track_rate, y, dy, psi, dpsi, log_mu0, log_stiffness, in this order. The same factor multiplies
<code>k_A</code> and <code>k_S</code>, and its logarithm is the last state.
</p>
<h4>Limitations</h4>
<p>
At creepages in the linear part of the creep curve readings determine the stiffness, but not friction. Otherwise those
of <a href=\"modelica://RailBraking.Predictions.LateralPredictionUnknownTrack\">LateralPredictionUnknownTrack</a>.
</p>
</html>"));
end LateralPredictionStiffnessUnknownTrack;
