within RailBraking.FMUs;
block TrainPredictionReduced "Two-part train as an estimator believes it to be, without suspension"
  extends Vehicles.PartialPrediction;
  Interfaces.RealOutput speed(final unit="m/s") = v "Speed of the train"
    annotation(Placement(transformation(extent={{100, 57}, {120, 77}})));
  Interfaces.RealOutput wheelset_speed[4](each final unit="rad/s") = w "Angular velocity of each group"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  Interfaces.RealOutput acceleration(final unit="m/s2") = der(v) "Acceleration of the train"
    annotation(Placement(transformation(extent={{100, -77}, {120, -57}})));
equation
  load = g*{m_wheelset[1] + m_wheelset[2], m_wheelset[3], m_wheelset[4], m_wheelset[5] + m_wheelset[6]};
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>Thirteen states: v, w, mu_b, alpha, in this order. Free of events.</p>
<h4>Limitations</h4>
<p>
Loads are static: braking shifts up to 7 % of the load of a wheelset of a single-axle group, which the estimate shows as
adhesion. Otherwise those of <a href=\"modelica://RailBraking.Vehicles.PartialPrediction\">PartialPrediction</a>.
</p>
</html>"));
end TrainPredictionReduced;
