within RailBraking.Components;
model Rest "When a train is at rest"
  extends Icons.Component;
  parameter Integer n(min=1) = 1 "Number of cars" annotation(Evaluate=true);
  parameter Types.Velocity v_rest(min=1e-6) = 1e-3 "Speed below which the train comes to rest if it can be held";
  parameter Types.Force F_small(min=1e-3) = 10 "Excess of the track force over the holding force that moves the train";
  Interfaces.RealInput v[n](each final unit="m/s") "Speed of each car"
    annotation(Placement(transformation(extent={{-120, 50}, {-100, 70}})));
  Interfaces.RealInput track_force(final unit="N") "Force of gradient and curve on the train, forward"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealInput capacity(final unit="N") "Force with which brakes and resistance hold the train at rest"
    annotation(Placement(transformation(extent={{-120, -70}, {-100, -50}})));
  Interfaces.BooleanOutput standstill(start=false, fixed=true) "= true, if the train is at rest"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
protected
  Types.Velocity v_max "Speed of the fastest car";
equation
  v_max = max(v);
  standstill = if pre(standstill) then track_force <= capacity + F_small
    else v_max <= v_rest and track_force <= capacity;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-70, 60}, {20, -50}, {80, -50}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
A train is at rest if no car moves faster than <code>v_rest</code> and it can be held as a whole.
All speeds are then exactly zero until the track pulls it forward with more force than brakes,
bearings and adhesion can hold. With a creep force law alone it would approach rest asymptotically.
</p>
<h4>Limitations</h4>
<p>
Forward motion only: a car that would run back against its couplers, or a train with released brakes
on a rising gradient, is stopped where its motion would reverse. Coming to rest discards m
v&sup2;/2, 0.02 J for a car of 40 t at <code>v_rest</code>. A train starts to move as a whole:
couplers do not let one car start before the others.
</p>
</html>"));
end Rest;
