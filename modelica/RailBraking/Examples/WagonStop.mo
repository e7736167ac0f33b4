within RailBraking.Examples;
model WagonStop "Wagon braked on a rail with lower friction under its front wheelset"
  extends Icons.Example;
  Plants.Wagon wagon(start_speed=10) "Wagon"
    annotation(Placement(transformation(extent={{-20, -20}, {20, 20}})));
equation
  wagon.mu0 = {0.25, 0.30};
  wagon.pressure_command = {1.5e5, 1.5e5};
  wagon.track_force = 0;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    experiment(StopTime=5, Tolerance=1e-7, Interval=0.01),
    Documentation(info="<html>
<p>Both wheelsets keep rolling; load moves to the front one while the wagon slows.</p>
</html>"));
end WagonStop;
