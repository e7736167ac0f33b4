within RailBraking.Components;
model TrainBody "All masses of the train along the track, with drag and rest"
  parameter Types.Mass m(start=84000) "Mass of the whole train, without rotating masses";
  parameter Types.Ratio c_drag = 0.9 "Drag coefficient";
  parameter Types.Area A_drag = 10 "Frontal area";
  parameter Types.Density rho_air = 1.2 "Density of the air";
  parameter Types.Velocity v_rest = 1e-3 "Speed at which the train comes to rest if it can be held";
  parameter Types.Force F_small = 10 "Force by which the track must exceed what holds the train to move it";
  parameter Types.Velocity v_start(start=22) "Speed at the start";
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
  Interfaces.BooleanOutput standstill(start=false, fixed=true) "= true, if the train stands"
    annotation(Placement(transformation(extent={{100, -77}, {120, -57}})));
  Types.Length s(start=0, fixed=true) "Distance travelled";
  Types.Velocity v(start=v_start, fixed=true) "Speed";
protected
  Types.Force drag "Drag of the air";
equation
  drag = rho_air/2*c_drag*A_drag*v^2;
  standstill = if pre(standstill) then track_force <= capacity + F_small
    else v <= v_rest and track_force <= capacity;
  a = if standstill then 0 else (track_force - F - drag)/m;
  der(v) = a;
  der(s) = v;
  when standstill then
    reinit(v, 0);
  end when;
  resistance_power = (drag - track_force)*v;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Rectangle(extent={{-80, 50}, {80, -50}}, lineColor={0, 0, 127}),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
A train that is slower than <code>v_rest</code> and can be held is at rest: its speed is exactly zero until the track
pulls
it forward harder than brakes, bearings and adhesion can hold. A creep force law alone would let it approach rest for
ever.
</p>
<h4>Limitations</h4>
<p>
Forward motion only: a train on a rising gradient with released brakes comes to rest and stays, where a real one
would roll back. Coming to rest discards m v_rest<sup>2</sup>/2, 0.04 J for 84 t.
</p>
</html>"));
end TrainBody;
