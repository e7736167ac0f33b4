within RailBraking.Validation;
model AcceleratedPipe "Accelerators open once, in an emergency brake only, and vent like a choked vessel"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=5e-3);

  constant Types.Volume V = 0.02 "Pipe of a vehicle";
  constant Types.Pressure p_open = 5e5 "Pressure at the start";
  constant Types.Pressure p_end = 2.5e5 "Pressure at which an accelerator closes";
  Pneumatics.Reservoir slow(V=V, p_start=p_open) "Pipe that a service brake empties";
  Pneumatics.Reservoir fast(V=V, p_start=p_open) "Pipe that an emergency brake empties";
  Pneumatics.Reservoir fed(V=V, p_start=p_open) "Pipe that neighbours refill while an emergency brake empties it";
  Pneumatics.Accelerator resting "Accelerator of the first pipe";
  Pneumatics.Accelerator venting "Accelerator of the second pipe";
  Pneumatics.Accelerator once "Accelerator of the third pipe";
  Pneumatics.Choke service(C=V/Pneumatics.p_free*4e4/(p_open + Pneumatics.p_free)) "Fall that begins with 0.4 bar/s";
  Pneumatics.Choke emergency(C=V/Pneumatics.p_free*2e5/(p_open + Pneumatics.p_free)) "Fall that begins with 2 bar/s";
  Pneumatics.Choke opening(C=emergency.C) "As emergency";
  Pneumatics.Choke neighbours(C=1.5*emergency.C) "Feeds more than opening takes once it is choked";
  Pneumatics.PrescribedSupply full "Pipe of the neighbours";
  Pneumatics.PrescribedSupply atmosphere[3] "Open air";
  Real openings(final unit="1", start=0, fixed=true) "Number of openings of the third accelerator";
  Types.Time vented(start=0, fixed=true) "Time for which the accelerator has vented";
  final parameter Types.Pressure P_open = p_open + Pneumatics.p_free "Absolute pressure at the start";
  final parameter Types.Time t_open = -0.05*log(1 - 0.5e5/2e5) "Time at which the lagging rate reaches 0.5 bar/s";
  final parameter Types.Time t_exact = V/Pneumatics.p_free/(2e-7 + emergency.C)
    *(log(P_open/(p_end + Pneumatics.p_free)) - 2e5*t_open/P_open) "Closed form of it, choked throughout";
equation
  connect(slow.port, resting.pipe);
  connect(slow.port, service.a);
  connect(service.b, atmosphere[1].port);
  connect(fast.port, venting.pipe);
  connect(fast.port, emergency.a);
  connect(emergency.b, atmosphere[2].port);
  connect(fed.port, once.pipe);
  connect(fed.port, opening.a);
  connect(opening.b, atmosphere[3].port);
  connect(full.port, neighbours.a);
  connect(neighbours.b, fed.port);
  full.pressure = p_open;
  atmosphere.pressure = fill(0, 3);
  when once.open then
    openings = pre(openings) + 1;
  end when;
  der(vented) = if venting.open then 1 else 0;
  error = (if resting.open then 1 else 0) + (if time < 5 then 0 else abs(vented/t_exact - 1) + abs(openings - 1));
  annotation (
    experiment(StopTime=6, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
A pipe that begins to fall by 0.4 bar a second stays as it is; in one that begins with 2 bar a second the vent opens
once the lagging pressure has seen 0.5 bar a second, and from there to 2.5 bar it takes V/(p_free &Sigma;C)
ln(P/P<sub>end</sub>). One whose pipe rises again as soon as it has closed opens once and not again.
</p>
</html>"));
end AcceleratedPipe;
