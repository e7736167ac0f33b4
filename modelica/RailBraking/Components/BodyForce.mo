within RailBraking.Components;
model BodyForce "Force on a car body, such as that of a magnetic track brake"
  extends Icons.Component;
  Interfaces.RealInput force(final unit="N") "Force on the car, forward"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.TranslationalFlange pivot "To the pivot of a car body"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  Interfaces.RealOutput power(final unit="W") "Power taken from the car"
    annotation(Placement(transformation(extent={{100, -70}, {120, -50}})));
equation
  pivot.f = -force;
  power = -force*pivot.v;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-90, 0}, {90, 0}}, color={0, 0, 127}),
        Line(points={{60, 20}, {90, 0}, {60, -20}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>The force acts on the connected component; that of a brake is negative.</p>
<h4>Limitations</h4>
<p>It neither pitches a bogie nor unloads wheelsets, and it does not hold the car at rest, see
<a href=\"modelica://RailBraking.Components.Rest\">Rest</a>.</p>
</html>"));
end BodyForce;
