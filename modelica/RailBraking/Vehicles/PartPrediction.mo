within RailBraking.Vehicles;
block PartPrediction "A group of wheelsets or a bogie, as an estimator believes it to be"
  extends Icons.Vehicle;
  extends PartialConsistPrediction;
  Interfaces.RealInput cylinder_pressure[n_groups](each final unit="Pa", each start=0)
    "Pressure in the cylinders of each group"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput acceleration(final unit="m/s2", start=0) "Acceleration of the train"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));
  Interfaces.RealOutput force(final unit="N") = sum(F) "Braking force of the track on all groups together"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
equation
  pressure = cylinder_pressure;
  train_acceleration = acceleration;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -40}, {-30, 30}, {20, 0}, {80, 50}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The part of a train that an estimator can treat by itself once the acceleration of the train is known: speed and
acceleration are all that it shares with the rest. As it stands, one group of static load; with one bogie, whose
wheelsets turn as one or, in two groups, apart. Free of events.
</p>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Vehicles.PartialPrediction\">PartialPrediction</a>.</p>
</html>"));
end PartPrediction;
