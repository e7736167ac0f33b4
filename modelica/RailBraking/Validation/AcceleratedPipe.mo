within RailBraking.Validation;
model AcceleratedPipe "Accelerators open in an emergency brake only, and vent as a choked vessel does"
  extends Interfaces.PartialValidation(tolerance=5e-3);

  constant Types.Volume V = 0.02 "Pipe of a vehicle";
  constant Types.Pressure p_open = 5e5 "Pressure at the start";
  constant Types.Pressure p_end = 2.5e5 "Pressure at which an accelerator closes";
  Pneumatics.Reservoir slow(V=V, p_start=p_open) "Pipe that a service brake empties";
  Pneumatics.Reservoir fast(V=V, p_start=p_open) "Pipe that an emergency brake empties";
  Pneumatics.Accelerator resting "On the one";
  Pneumatics.Accelerator venting "On the other";
  Pneumatics.Choke service(C=V/Pneumatics.p_free*4e4/(p_open + Pneumatics.p_free)) "Begins with 0.4 bar a second";
  Pneumatics.Choke emergency(C=V/Pneumatics.p_free*2e5/(p_open + Pneumatics.p_free)) "Begins with 2 bar a second";
  Pneumatics.PrescribedSupply atmosphere[2] "Open air";
  Types.Time vented(start=0, fixed=true) "Time for which the accelerator has vented";
  final parameter Types.Pressure P_open = p_open + Pneumatics.p_free "Absolute pressure at the start";
  final parameter Types.Time t_open = -0.05*log(1 - 0.5e5/2e5) "When the lag of T_sense has seen 0.5 bar/s of the fall";
  final parameter Types.Time t_exact = V/Pneumatics.p_free/(2e-7 + emergency.C)
    *(log(P_open/(p_end + Pneumatics.p_free)) - 2e5*t_open/P_open) "Closed form of it, choked throughout";
equation
  connect(slow.port, resting.pipe);
  connect(slow.port, service.a);
  connect(service.b, atmosphere[1].port);
  connect(fast.port, venting.pipe);
  connect(fast.port, emergency.a);
  connect(emergency.b, atmosphere[2].port);
  atmosphere[1].pressure = 0;
  atmosphere[2].pressure = 0;
  der(vented) = if venting.open then 1 else 0;
  error = (if resting.open then 1 else 0) + (if time < 5 then 0 else vented/t_exact - 1);
  annotation (
    experiment(StopTime=6, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
A pipe that begins to fall by 0.4 bar a second stays as it is; in one that begins with 2 bar a second the vent opens
once the lagging pressure has seen 0.5 bar a second, and from there to 2.5 bar it takes V/(p_free &Sigma;C)
ln(P/P<sub>end</sub>).
</p>
</html>"));
end AcceleratedPipe;
