within RailBraking.Examples;
model EmergencyStopDry "Emergency stop from 85 km/h on a dry rail"
  FMUs.TwoPartTrain train(speed_start=85/3.6, k_A=dry.k_A, k_S=dry.k_S, A_falling=dry.A, B_falling=dry.B) "Train"
    annotation(Placement(transformation(extent={{-60, -20}, {-20, 20}})));
  parameter Contact.Surfaces.Dry dry "Rail"
    annotation(Placement(transformation(extent={{20, -20}, {60, 20}})));
  Types.Ratio build_up "Share of full pressure after 0.4 s of dead time, with a time constant of 0.5 s";
equation
  build_up = if time < 0.4 then 0 else 1 - exp(-(time - 0.4)/0.5);
  train.pressure_command = build_up*train.p_max;
  train.mu0 = fill(dry.mu0, 6);
  train.track_force = 0;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Polygon(points={{-40, 60}, {60, 0}, {-40, -60}}, lineColor={0, 0, 127}),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    experiment(StopTime=25, Tolerance=1e-6, Interval=0.01),
    Documentation(info="<html>
<p>The train stops after 265 m in 21.2 s. Watch <code>train.speed</code>, <code>train.pad_friction</code> and
<code>train.wheelset_load</code>.</p>
</html>"));
end EmergencyStopDry;
