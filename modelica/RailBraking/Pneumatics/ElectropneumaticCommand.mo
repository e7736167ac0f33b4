within RailBraking.Pneumatics;
block ElectropneumaticCommand "Pressure demanded by wire: the same delay and build-up in each car"
  extends Icons.Pneumatic;
  parameter Types.Time delay = 0.4 "Time from the demand to the first pressure";
  parameter Types.Time T = 0.5 "Time constant of the build-up";
  parameter Types.Time T_release = 0.5 "Time constant of the release";
  Interfaces.RealInput demand(final unit="Pa") "Pressure that the driver demands"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealOutput pressure(final unit="Pa") "Pressure that reaches the brake units"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  DelayLine wire(delay=delay, final period=0.01) "Electrical and mechanical dead time"
    annotation(Placement(transformation(extent={{-60, -20}, {-20, 20}})));
protected
  Types.Pressure p(start=0, fixed=true) "Pressure";
equation
  wire.u = demand;
  der(p) = (wire.y - p)/noEvent(if wire.y > p then T else T_release);
  pressure = p;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -40}, {-30, -40}, {-10, 10}, {20, 35}, {80, 40}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Dead time and a first-order lag, the same everywhere in the train: the equivalent time is delay + T, 0.8 to 1.2 s for
trains
with
electropneumatic brakes (estimated: dead time 0.3 to 0.5 s, T 0.4 to 0.6 s).
</p>
<h4>Limitations</h4>
<p>The dead time is at most 1 s and counts from a sample, every 10 ms. The supply is not modelled.</p>
</html>"));
end ElectropneumaticCommand;
