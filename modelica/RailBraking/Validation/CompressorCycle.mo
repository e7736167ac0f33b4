within RailBraking.Validation;
model CompressorCycle "A compressor fills a reservoir in V (p_out - p_in)/(p_free q)"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-4);

  Pneumatics.Reservoir reservoir(V=0.5, p_start=8e5) "Main reservoir";
  Pneumatics.Compressor compressor(q_nominal=0.02, p_in=8.5e5, p_out=10e5, running_start=true) "Compressor";
  Pneumatics.Reservoir brake(V=0.1) "Reservoir to fill";
  Pneumatics.Choke choke(C=1e-12) "Almost closed choke";
  Types.Time t_exact "Time at which the compressor stops, closed form";
equation
  connect(compressor.port, reservoir.port);
  connect(reservoir.port, choke.a);
  connect(choke.b, brake.port);
  t_exact = 0.5*2e5/(1.01325e5*0.02);
  error = (0.5*(reservoir.pressure - 8e5) + 0.1*brake.pressure - 1.01325e5*0.02*min(time, t_exact))/(0.5*2e5);
  annotation (
    experiment(StopTime=80, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
Balance of the air: the air delivered until the compressor stops at 10 bar is in the reservoir and
in the volume that it feeds.
</p>
</html>"));
end CompressorCycle;
