within RailBraking.FMUs;
block TrainPredictionReduced "Two-part train as an estimator believes it to be, without suspension"
  extends Vehicles.PartialTwoPartPrediction(final n_bogies=0);
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
adhesion. Otherwise those of
<a href=\"modelica://RailBraking.Vehicles.PartialTwoPartPrediction\">PartialTwoPartPrediction</a>.
</p>
</html>"));
end TrainPredictionReduced;
