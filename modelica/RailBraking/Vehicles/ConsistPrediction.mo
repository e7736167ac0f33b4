within RailBraking.Vehicles;
block ConsistPrediction "Train of any number of groups and bogies as modelled by an estimator"
  extends Icons.Vehicle;
  extends PartialBodyPrediction(final m=sum(m_group));
  extends PartialConsistPrediction;
  Interfaces.RealInput cylinder_pressure[n_groups](each final unit="Pa", each start=0)
    "Cylinder pressure of each group"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput track_force(final unit="N", start=0) "Force of gradient and curve, forward"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));
  Interfaces.RealOutput speed(final unit="m/s") = v "Speed of the train"
    annotation(Placement(transformation(extent={{100, 65}, {120, 85}})));
  Interfaces.RealOutput wheelset_speed[n_groups](each final unit="rad/s") = w "Angular velocity of each group"
    annotation(Placement(transformation(extent={{100, 15}, {120, 35}})));
  Interfaces.RealOutput deflection[2*n_bogies](each final unit="m") = dz
    "Deflection of the primary suspension, change from static, compression positive"
    annotation(Placement(transformation(extent={{100, -35}, {120, -15}})));
  Interfaces.RealOutput acceleration(final unit="m/s2") = a "Acceleration of the train"
    annotation(Placement(transformation(extent={{100, -85}, {120, -65}})));
equation
  pressure = cylinder_pressure;
  train_acceleration = a;
  thrust = track_force - sum(F);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -40}, {-30, 30}, {20, 0}, {80, 50}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>Free of events; states v, w, mu_b, alpha, dz, ddz.</p>
<h4>Limitations</h4>
<p>
Those of <a href=\"modelica://RailBraking.Vehicles.PartialPrediction\">PartialPrediction</a> and of
<a href=\"modelica://RailBraking.Vehicles.PartialBodyPrediction\">PartialBodyPrediction</a>.
</p>
</html>"));
end ConsistPrediction;
