within RailBraking.Components;
model ShaftTorque "Torque of a drive or an electrodynamic brake on an axle"
  extends Icons.Component;
  Interfaces.RealInput torque(final unit="N.m") "Torque on the axle, forward"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RotationalFlange shaft "To the shaft of an axle"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  Interfaces.RealOutput power(final unit="W") "Power taken from the axle"
    annotation(Placement(transformation(extent={{100, -70}, {120, -50}})));
equation
  shaft.tau = -torque;
  power = -torque*shaft.w;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-100, 0}, {100, 0}}, color={0, 0, 127}),
        Ellipse(extent={{-40, 40}, {40, -40}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>The torque acts on the connected component; that of a brake is negative.</p>
<h4>Limitations</h4>
<p>Stiff and without inertia: rotors that turn with the axle belong to the inertia of the axle.</p>
</html>"));
end ShaftTorque;
