within RailBraking.Validation;
model ChokedVessel "A reservoir empties through a choke according to the nozzle formula"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-5);

  Pneumatics.Reservoir vessel(V=0.1, p_start=8e5) "Vessel";
  Pneumatics.Choke choke(C=2e-8) "Choke";
  Pneumatics.Reservoir outside(V=1e9) "Volume so large that it represents the atmosphere";
  Types.Pressure p_exact "Closed form";
equation
  connect(vessel.port, choke.a);
  connect(choke.b, outside.port);
  p_exact = (8e5 + 1.01325e5)*exp(-2e-8*1.01325e5*time/0.1) - 1.01325e5;
  error = (vessel.pressure - p_exact)/8e5;
  annotation (
    experiment(StopTime=25, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>While the outlet is choked, V dP/dt = -p_free C P: the absolute pressure P falls exponentially, here until 4
bar.</p>
</html>"));
end ChokedVessel;
