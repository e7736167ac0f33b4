within RailBraking.Validation;
model IsolatedUnit "An isolated unit is vented and consumes no air"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-5);

  Pneumatics.Reservoir reservoir(V=0.1, p_start=5e5) "Supply";
  Pneumatics.IsolatingCock cock(isolated=true, C=1e-8) "Closed cock";
  Pneumatics.Reservoir cylinder(V=0.01, p_start=4e5) "Brake cylinder, full at the start";
  Types.Pressure p_exact "Closed form while the vent is choked";
equation
  connect(reservoir.port, cock.a);
  connect(cock.b, cylinder.port);
  p_exact = 5.01325e5*exp(-1e-8*1.01325e5*time/0.01) - 1.01325e5;
  error = max(abs(reservoir.pressure - 5e5), abs(cylinder.pressure - p_exact))/4e5;
  annotation (
    experiment(StopTime=8, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>The reservoir keeps its pressure; the cylinder empties like a reservoir through a choke, here until 1 bar.</p>
</html>"));
end IsolatedUnit;
