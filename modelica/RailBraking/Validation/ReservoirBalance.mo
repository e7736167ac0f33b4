within RailBraking.Validation;
model ReservoirBalance "Air consumption of valves lowers the pressure of the reservoir, which filling follows"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-5);

  Pneumatics.Reservoir reservoir(V=0.02, p_start=6e5) "Reservoir, small enough for a pressure drop";
  Pneumatics.RelayValve relay "Relay valve at a pressure below that of the cylinder";
  Pneumatics.SuppliedCylinder cylinder(p_max=3.8e5, V=6e-3, leak=0, T_vent=0.2) "Cylinder";
  Types.Volume used(start=0, fixed=true) "Free air taken, at the fill valve";
  Types.Pressure p_exact "Balance of the reservoir";
equation
  relay.pressure = 3.5e5;
  connect(reservoir.port, relay.inlet);
  connect(relay.port, cylinder.supply);
  cylinder.command = if mod(time, 3) < 1.5 then 1 else -1;
  der(used) = cylinder.air_flow;
  p_exact = 6e5 - 1.01325e5*used/0.02;
  error = max(abs(reservoir.pressure - p_exact), max(cylinder.pressure - 3.5e5, 0))/6e5;
  annotation (
    experiment(StopTime=15, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>V p + p_free times the air used is constant, isothermally: five strokes, until there is too little for a full
one.</p>
</html>"));
end ReservoirBalance;
