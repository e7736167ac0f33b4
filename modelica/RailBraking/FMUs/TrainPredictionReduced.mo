within RailBraking.FMUs;
block TrainPredictionReduced "Two-part train as an estimator believes it to be, without suspension"
  extends Vehicles.PartialPrediction;
  Interfaces.RealOutput speed(final unit="m/s") = v "Speed of the train";
  Interfaces.RealOutput wheelset_speed[4](each final unit="rad/s") = w "Angular velocity of each group";
  Interfaces.RealOutput acceleration(final unit="m/s2") = der(v) "Acceleration of the train";
equation
  load = g*{m_wheelset[1] + m_wheelset[2], m_wheelset[3], m_wheelset[4], m_wheelset[5] + m_wheelset[6]};
  annotation (Documentation(info="<html>
<p>Thirteen states: v, w, mu_b, alpha, in this order. Free of events.</p>
<h4>Limitations</h4>
<p>
Loads are static: braking shifts up to 7 % of the load of a wheelset of a single-axle group, which the estimate shows as
adhesion. Otherwise those of <a href=\"modelica://RailBraking.Vehicles.PartialPrediction\">PartialPrediction</a>.
</p>
</html>"));
end TrainPredictionReduced;
