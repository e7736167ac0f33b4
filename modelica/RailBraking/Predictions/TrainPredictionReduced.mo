within RailBraking.Predictions;
block TrainPredictionReduced "Two-part train as modelled by an estimator, without suspension"
  extends Icons.Vehicle;
  extends Vehicles.PartialTwoPartPrediction(final n_bogies=0);
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>Thirteen states: v, w, mu_b, alpha, in this order. Free of events.</p>
<h4>Limitations</h4>
<p>
Loads are static: braking shifts up to 7 % of the load of a wheelset of a single-axle group, which
appears as adhesion in the estimate. Otherwise those of
<a href=\"modelica://RailBraking.Vehicles.PartialTwoPartPrediction\">PartialTwoPartPrediction</a>.
</p>
</html>"));
end TrainPredictionReduced;
