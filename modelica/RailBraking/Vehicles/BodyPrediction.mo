within RailBraking.Vehicles;
block BodyPrediction "All masses of a train along the track, as modelled by an estimator"
  extends Icons.Vehicle;
  extends PartialBodyPrediction;
  Interfaces.RealInput force(final unit="N", start=0) "Braking force of the track on all wheelsets"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput track_force(final unit="N", start=0) "Force of gradient and curve, forward"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));
  Interfaces.RealOutput acceleration(final unit="m/s2") = a "Acceleration of the train"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
equation
  thrust = track_force - force;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -40}, {-30, 30}, {20, 0}, {80, 50}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>The states that the parts of a train share in an estimator: its speed and acceleration.</p>
<h4>Limitations</h4>
<p>
Those of <a href=\"modelica://RailBraking.Vehicles.PartialBodyPrediction\">PartialBodyPrediction</a>.
</p>
</html>"));
end BodyPrediction;
