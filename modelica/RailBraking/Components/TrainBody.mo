within RailBraking.Components;
model TrainBody "All masses of the train along the track, with drag and rest"
  extends Icons.Component;
  parameter Types.Mass m(start=84000) "Mass of the whole train, without rotating masses";
  parameter Types.Ratio c_drag = 0.9 "Drag coefficient";
  parameter Types.Area A_drag = 10 "Frontal area";
  parameter Types.Density rho_air = 1.2 "Density of the air";
  parameter Types.Velocity v_rest = 1e-3 "Speed below which the train comes to rest if it can be held";
  parameter Types.Force F_small = 10 "Excess of the track force over the holding force that moves the train";
  parameter Types.Velocity start_speed(start=22) "Speed at the start";
  Interfaces.RealInput F(final unit="N") "Braking force of the track on all wheelsets"
    annotation(Placement(transformation(extent={{-120, 57}, {-100, 77}})));
  Interfaces.RealInput track_force(final unit="N") "Force of gradient and curve, forward"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealInput capacity(final unit="N") "Force with which brakes and resistance hold the train at rest"
    annotation(Placement(transformation(extent={{-120, -77}, {-100, -57}})));
  Interfaces.RealOutput a(final unit="m/s2") "Acceleration"
    annotation(Placement(transformation(extent={{100, 57}, {120, 77}})));
  Interfaces.RealOutput resistance_power(final unit="W")
    "Power of drag and track force, positive when it slows the train"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  Interfaces.BooleanOutput standstill(start=false, fixed=true) "= true, if the train is at rest"
    annotation(Placement(transformation(extent={{100, -77}, {120, -57}})));
  Types.Length s(start=0, fixed=true, nominal=1) "Distance travelled";
  Types.Velocity v "Speed";
protected
  final parameter Data.Drag drag = Data.Drag(c_drag=c_drag, A_drag=A_drag, rho_air=rho_air) "Air";
  CarBody body(m=m, start_speed=start_speed, drag=drag) "All masses in one body"
    annotation(Placement(transformation(extent={{-20, -20}, {20, 20}})));
  BodyForce wheelsets "Force of the track on all wheelsets"
    annotation(Placement(transformation(extent={{-60, -80}, {-20, -40}})));
  Rest rest(final n=1, v_rest=v_rest, F_small=F_small) "Detection of standstill"
    annotation(Placement(transformation(extent={{20, -80}, {60, -40}})));
equation
  connect(wheelsets.pivot, body.pivot) annotation(Line(points={{-18, -60}, {0, -60}, {0, -22}}, color={0, 0, 127}));
  connect(track_force, body.track_force)
    annotation(Line(points={{-110, 0}, {-60, 0}, {-60, 12}, {-22, 12}}, color={0, 0, 127}));
  connect(track_force, rest.track_force)
    annotation(Line(points={{-110, 0}, {-70, 0}, {-70, -90}, {10, -90}, {10, -60}, {18, -60}}, color={0, 0, 127}));
  connect(capacity, rest.capacity)
    annotation(Line(points={{-110, -67}, {-80, -67}, {-80, -95}, {14, -95}, {14, -72}, {18, -72}}, color={0, 0, 127}));
  connect(rest.standstill, body.standstill)
    annotation(Line(points={{62, -60}, {70, -60}, {70, -30}, {-30, -30}, {-30, -12}, {-22, -12}}, color={0, 0, 127}));
  connect(rest.standstill, standstill)
    annotation(Line(points={{62, -60}, {90, -60}, {90, -67}, {110, -67}}, color={0, 0, 127}));
  connect(body.a, a) annotation(Line(points={{22, 16}, {80, 16}, {80, 67}, {110, 67}}, color={0, 0, 127}));
  connect(body.resistance_power, resistance_power)
    annotation(Line(points={{22, 8}, {60, 8}, {60, 0}, {110, 0}}, color={0, 0, 127}));
  wheelsets.force = -F;
  rest.v = {body.v};
  v = body.v;
  der(s) = v;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-80, 50}, {80, -50}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
<a href=\"modelica://RailBraking.Components.CarBody\">CarBody</a> and <a
href=\"modelica://RailBraking.Components.Rest\">Rest</a> with signals in place of connectors, for a train that is one
mass.
</p>
<h4>Limitations</h4>
<p>
Those of its components. Coming to rest discards m v_rest<sup>2</sup>/2, 0.04 J for 84 t.
</p>
</html>"));
end TrainBody;
