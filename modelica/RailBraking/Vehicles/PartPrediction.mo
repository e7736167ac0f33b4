within RailBraking.Vehicles;
block PartPrediction "A group of wheelsets or a bogie, as modelled by an estimator"
  extends Icons.Vehicle;
  extends PartialConsistPrediction;
  Interfaces.RealInput cylinder_pressure[n_groups](each final unit="Pa", each start=0)
    "Cylinder pressure of each group"
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
A part of a train that an estimator can treat separately if the acceleration of the train is known:
it shares only speed and acceleration with the rest. By default it is one group of static load; with
one bogie, its wheelsets turn as one or, in two groups, independently. Free of events.
</p>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Vehicles.PartialPrediction\">PartialPrediction</a>.</p>
</html>"));
end PartPrediction;
