within RailBraking.Examples;
model BlendedStop "Stop of a tram with electrodynamic, friction and track brake"
  extends Icons.Example;
  parameter Types.Mass m = 42000 "Mass";
  parameter Types.Acceleration demanded = 1.2 "Demanded deceleration";
  Components.Blending blending(n=3, share={0.5, 0, 0.5}) "Outer bogies are motored"
    annotation(Placement(transformation(extent={{-60, 20}, {-20, 60}})));
  Components.ElectrodynamicBrake dynamic(F_max=40e3, P_max=5e5, v_full=2, v_end=0.5)
    "Electrodynamic brake of both motored bogies"
    annotation(Placement(transformation(extent={{20, 20}, {60, 60}})));
  Pneumatics.ElectropneumaticCommand wire[3](each delay=0.2, each T=0.2, each T_release=0.2) "Friction brakes"
    annotation(Placement(transformation(extent={{-60, -60}, {-20, -20}})));
  Components.MagneticTrackBrake magnets(n_magnets=6, F_attraction=55e3, v_max=25) "Two to a bogie"
    annotation(Placement(transformation(extent={{20, -60}, {60, -20}})));
  Types.Length s(start=0, fixed=true) "Distance";
  Types.Velocity v(start=50/3.6, fixed=true) "Speed";
protected
  constant Types.Area area = 0.1 "Force of a friction brake over its pressure";
  Types.Force friction "Lag of the friction brakes";
equation
  for i in 1:3 loop
    blending.demand[i] = m*demanded/3;
    blending.kept[i] = 1;
    wire[i].demand = blending.friction[i]/area;
  end for;
  connect(dynamic.available, blending.available)
    annotation(Line(points={{61, 50}, {80, 50}, {80, 80}, {-80, 80}, {-80, 28}, {-62, 28}}, color={0, 0, 127}));
  connect(blending.dynamic_demand, dynamic.demand)
    annotation(Line(points={{-19, 50}, {18, 50}}, color={0, 0, 127}));
  connect(dynamic.force, blending.dynamic_force)
    annotation(Line(points={{61, 30}, {80, 30}, {80, 5}, {-40, 5}, {-40, 18}}, color={0, 0, 127}));
  dynamic.speed = v;
  magnets.speed = v;
  magnets.command = if time > 1 then 1 else 0;
  friction = area*sum(wire.pressure);
  der(s) = v;
  m*der(v) = -noEvent(if v > 0 then dynamic.force + friction + magnets.force else 0);
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    experiment(StopTime=8, Tolerance=1e-6, Interval=0.01),
    Documentation(info="<html>
<p>
The electrodynamic brake acts first; friction brakes respond later and take over below 2 m/s; after
a second the magnets add force that does not depend on adhesion.
Compare dynamic.force, friction and magnets.force. Data are estimated.
</p>
</html>"));
end BlendedStop;
