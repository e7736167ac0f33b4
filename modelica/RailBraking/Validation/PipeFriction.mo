within RailBraking.Validation;
model PipeFriction "Pressure of steady isothermal flow in a brake pipe falls according to Darcy"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-4);

  Pneumatics.Reservoir vessel(V=1e6, p_start=5e5) "Volume so large that its pressure is constant";
  Pneumatics.BrakePipe pipe(n=12, length=fill(26.4, 12)) "317 m of pipe";
  Pneumatics.Choke leak(C=2e-8) "At the far end";
  Pneumatics.Reservoir outside(V=1e9) "Volume so large that it represents the atmosphere";
  Types.VolumeFlow q "Free air through the leak";
  Real fall(final unit="kg2/(m2.s4)")
    "Difference of the square of the absolute pressure from the end to the middle of the last cell";
  Real fall_exact(final unit="kg2/(m2.s4)") "Closed form";
equation
  connect(vessel.port, pipe.front);
  connect(pipe.rear, leak.a);
  connect(leak.b, outside.port);
  q = leak.a.q;
  fall = (vessel.pressure + 1.01325e5)^2 - (pipe.pressure[12] + 1.01325e5)^2;
  fall_exact = (0.03*11.5*26.4/0.032 + 2*log((vessel.pressure + 1.01325e5)/(pipe.pressure[12] + 1.01325e5)))
    *1.2041*1.01325e5*(q/(3.141592653589793/4*0.032^2))^2;
  error = if time < 50 then 0 else (fall - fall_exact)/fall_exact;
  annotation (
    experiment(StopTime=60, Tolerance=1e-8, Interval=0.1),
    Documentation(info="<html>
<p>
P<sub>1</sub>&sup2; - P<sub>2</sub>&sup2; = (friction L/D + 2 ln(P<sub>1</sub>/P<sub>2</sub>)) rho_free p_free
(q/A)&sup2;, once the leak at the far end flows steadily.
</p>
</html>"));
end PipeFriction;
