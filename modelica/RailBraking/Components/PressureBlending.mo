within RailBraking.Components;
block PressureBlending "Dynamic brakes first, friction brakes for the rest, in pressures of brake valves"
  extends Icons.Component;
  parameter Integer n(min=1) = 1 "Number of brake valves";
  parameter Boolean across = false "= true, if dynamic brakes also brake for valves without one"
    annotation(Evaluate=true);
  parameter Types.Area force_per_pressure[n](each start=0.01)
    "Rim force of the friction brakes of a valve over their pressure beyond the springs, with nominal friction";
  parameter Types.Pressure p_spring[n] = fill(0, n) "Pressure that the springs hold back";
  Interfaces.RealInput pressure[n](each final unit="Pa") "Demanded pressure of each valve"
    annotation(Placement(transformation(extent={{-120, 50}, {-100, 70}})));
  Interfaces.RealInput available[n](each final unit="N") "Available force of the dynamic brakes of each valve"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealInput force[n](each final unit="N") "Actual force of the dynamic brakes of each valve"
    annotation(Placement(transformation(extent={{-120, -70}, {-100, -50}})));
  Interfaces.RealOutput share[n](each final unit="1") "Demanded share of the available dynamic force of each valve"
    annotation(Placement(transformation(extent={{100, 40}, {120, 60}})));
  Interfaces.RealOutput friction[n](each final unit="Pa") "Pressure that is left to the friction brakes of each valve"
    annotation(Placement(transformation(extent={{100, -60}, {120, -40}})));
protected
  Types.Force demand[n] "Demanded force of each valve";
  Types.Force lacking[n] "Demand that the dynamic brakes of the valve do not provide";
  Types.Ratio kept "Part of the lacking force that no dynamic brake of another valve provides";
  Types.Ratio common "Demanded share of all dynamic brakes";
equation
  for i in 1:n loop
    demand[i] = force_per_pressure[i]*noEvent(max(pressure[i] - p_spring[i], 0));
    lacking[i] = noEvent(max(demand[i] - force[i], 0));
    share[i] = noEvent(min(if across then common else demand[i]/max(available[i], 1e-3), 1));
    friction[i] = noEvent(min(pressure[i], p_spring[i])) + kept*lacking[i]/force_per_pressure[i];
  end for;
  common = noEvent(sum(demand)/max(sum(available), 1e-3));
  kept = noEvent(if across then max(sum(demand) - sum(force), 0)/max(sum(lacking), 1e-3) else 1);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-60, 60}, {60, 0}}, lineColor={0, 0, 127}),
        Rectangle(extent={{-60, 0}, {60, -60}}, lineColor={0, 0, 127}, fillColor={0, 0, 127},
fillPattern=FillPattern.Solid)}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The demanded pressures are a demand for force, with the nominal friction of the pads. Dynamic brakes provide it as far
as they can; friction brakes get the pressure for the rest, and all of it where a dynamic brake fails or fades out.
With <code>across</code>, dynamic brakes share the demand of all valves in proportion to their available force, and what
they brake beyond the demand of their own valve relieves the friction brakes of the others in equal parts.
</p>
<p>Relieved cylinders keep the pressure that the springs hold back, so that pads touch without force.</p>
<h4>Limitations</h4>
<p>
As in <a href=\"modelica://RailBraking.Components.Blending\">Blending</a>, of which this is the form for pressures, the
fade-out is not anticipated. Friction that differs from the nominal one changes the sum of the forces when the shares
change.
</p>
</html>"));
end PressureBlending;
