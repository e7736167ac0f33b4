within RailBraking.Validation;
model Inshot "A distributor with an inshot has its share at once, and rises linearly to 95 % in its filling time"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=0.02);

  constant Types.Ratio inshot = 0.1 "Share of the highest pressure";
  constant Types.Time T_fill = 24 "Filling time";
  constant Types.Pressure p_max = 3.8e5 "Highest cylinder pressure";
  Pneumatics.BrakePipe pipe(n=1, length={14}) "Brake pipe of one wagon";
  Pneumatics.DriversBrakeValve valve "Valve";
  Pneumatics.Reservoir main(V=1, p_start=9e5) "Main reservoir";
  Pneumatics.Reservoir auxiliary(V=0.1, p_start=5e5) "Auxiliary reservoir";
  Pneumatics.Distributor distributor(p_max=p_max, T_fill=T_fill, inshot=inshot) "In position G";
  Types.Ratio expected "Share of the highest pressure from one second after the demand to 95 %";
equation
  connect(main.port, valve.supply);
  connect(valve.pipe, pipe.front);
  connect(pipe.branch[1], distributor.pipe);
  connect(auxiliary.port, distributor.supply);
  valve.demand = if time < 1 then 5e5 else 0;
  expected = inshot + (0.95 - inshot)*(time - 1)/T_fill;
  error = if time < 2 or time > T_fill then 0 else distributor.pressure/p_max - expected;
  annotation (
    experiment(StopTime=30, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>The tolerance is the pressure that fills while the pipe is vented, some tenths of a second.</p>
</html>"));
end Inshot;
