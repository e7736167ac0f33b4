within RailBraking.Components;
model Coupler "Coupler between two cars: spring, damper and slack; a drawbar if it is stiff and without slack"
  extends Icons.Component;
  parameter Types.Stiffness k(min=1, start=5e7) "Stiffness";
  parameter Types.Damping c(min=0, start=5e5) "Damping";
  parameter Types.Length slack(min=0) = 0 "Slack between pulling and pushing, initially half of it to either side";
  parameter Types.Length x_small(min=1e-6) = 1e-4 "Rounding of the ends of the slack";
  Interfaces.TranslationalFlange front "To the car ahead"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.TranslationalFlange rear "To the car behind"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  Interfaces.RealOutput force(final unit="N") "Force in the coupler, positive when it pulls"
    annotation(Placement(transformation(extent={{100, 50}, {120, 70}})));
  Interfaces.RealOutput power(final unit="W") "Power that the cars put into the coupler"
    annotation(Placement(transformation(extent={{100, -70}, {120, -50}})));
  Types.Length x(start=0, fixed=true, nominal=1e-2) "Elongation, change from the start";
  Types.Length stretch "Elongation beyond the slack, negative when it pushes";
protected
  constant Types.Length x_least = 1e-10 "Keeps the share at one without slack";
  Types.Velocity dv "Rate of the elongation";
  Types.Ratio share "Effective share of the damping";
equation
  dv = front.v - rear.v;
  der(x) = dv;
  stretch = Pneumatics.positivePart(x - slack/2, x_small) - Pneumatics.positivePart(-x - slack/2, x_small);
  share = (stretch^2 + x_least^2)/(stretch^2 + (10*x_small*slack/(slack + x_small))^2 + x_least^2);
  force = k*stretch + share*c*dv;
  front.f = force;
  rear.f = -force;
  power = force*dv;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(
          points={
            {-100, 0}, {-60, 0}, {-50, 20}, {-30, -20}, {-10, 20}, {10, -20}, {30, 20}, {50, -20}, {60, 0}, {100, 0}},
          color={0, 0, 127}),
        Rectangle(extent={{-60, -40}, {60, -70}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
With the elongation x, dx/dt = v_front - v_rear, and beyond the slack d = max(x - slack/2, 0) - max(-x - slack/2, 0):
force = k d + c dx/dt d&sup2;/(d&sup2; + (10 x_small)&sup2;), so that the damper begins to act at contact; without slack
force = k x + c dx/dt. Corners are rounded over <code>x_small</code>. Connect <code>front</code> with the rear end of
the car ahead.
</p>
<h4>Limitations</h4>
<p>
Buffers and hooks have the same stiffness, and the damper acts in both directions: right after an
impact it may pull, which a buffer cannot. Hysteresis of friction draw gears is not modelled. A
stiffness of 5e7 N/m or more represents a drawbar: two cars of 40 t oscillate against each other at
8 Hz, and a force of 10 kN extends it by 0.2 mm.
</p>
</html>"));
end Coupler;
