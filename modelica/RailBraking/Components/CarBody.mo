within RailBraking.Components;
model CarBody "Mass of a car along the track, with drag"
  extends Icons.Component;
  parameter Types.Mass m(min=1e-3, start=40000) "Mass of the car and its bogies, without rotating masses";
  parameter Types.Velocity start_speed(min=0, start=22) "Speed at the start";
  parameter Data.Drag drag "Air";
  Interfaces.TranslationalFlange front "Front end"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.TranslationalFlange rear "Rear end"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  Interfaces.TranslationalFlange pivot "Bogies, and other brakes of the car"
    annotation(Placement(transformation(extent={{-10, -120}, {10, -100}})));
  Interfaces.RealInput track_force(final unit="N") "Force of gradient and curve on this car, forward"
    annotation(Placement(transformation(extent={{-120, 50}, {-100, 70}})));
  Interfaces.BooleanInput standstill "= true, if the train is at rest"
    annotation(Placement(transformation(extent={{-120, -70}, {-100, -50}})));
  Interfaces.RealOutput a(final unit="m/s2") "Acceleration"
    annotation(Placement(transformation(extent={{100, 70}, {120, 90}})));
  Interfaces.RealOutput resistance_power(final unit="W")
    "Power of drag and track force, positive when it slows the car"
    annotation(Placement(transformation(extent={{100, 30}, {120, 50}})));
  Interfaces.RealOutput kinetic_energy(final unit="J") "Energy of motion along the track"
    annotation(Placement(transformation(extent={{100, -50}, {120, -30}})));
  Types.Velocity v(start=start_speed, fixed=true, nominal=1, stateSelect=StateSelect.prefer) "Speed";
protected
  Types.Force drag_force "Drag of the air";
equation
  front.v = v;
  rear.v = v;
  pivot.v = v;
  drag_force = drag.rho_air/2*drag.c_drag*drag.A_drag*v^2;
  a = if standstill then 0 else (track_force + pivot.f + front.f + rear.f - drag_force)/m;
  der(v) = a;
  when standstill then
    reinit(v, 0);
  end when;
  resistance_power = (drag_force - track_force)*v;
  kinetic_energy = m*v^2/2;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-80, 50}, {80, -50}}, lineColor={0, 0, 127}),
        Line(points={{-100, 0}, {-80, 0}}, color={0, 0, 127}),
        Line(points={{80, 0}, {100, 0}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
m dv/dt = track_force + pivot.f + front.f + rear.f - rho_air/2 c_drag A_drag v&sup2;. When the train comes to rest,
see <a href=\"modelica://RailBraking.Components.Rest\">Rest</a>, the speed is exactly zero.
</p>
<h4>Limitations</h4>
<p>
The body neither bounces nor pitches. The height of couplers has no effect. Cars that are joined
rigidly are one body with the bogies of all.
</p>
</html>"));
end CarBody;
