within RailBraking.Validation;
model PipeFront "The speed of the front in a brake pipe is 250 to 300 m/s"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=25/275);

  parameter Integer n = 60 "Cells";
  Pneumatics.BrakePipe pipe(n=n, length=fill(10, n)) "600 m of pipe";
  Pneumatics.DriversBrakeValve valve "Valve, vented at the start";
  Pneumatics.Reservoir main(V=1, p_start=9e5) "Main reservoir";
  Types.Time arrival(start=0, fixed=true) "Time at which the pressure has fallen by 0.1 bar in the last cell";
  Types.Velocity front "Speed of the front";
equation
  connect(main.port, valve.supply);
  connect(valve.pipe, pipe.front);
  valve.demand = if time < 1 then 5e5 else 0;
  when pipe.pressure[n] < 4.9e5 then
    arrival = time - 1;
  end when;
  front = if time < 4 then 275 else 595/max(arrival, 1e-3);
  error = (front - 275)/275;
  annotation (
    experiment(StopTime=5, Tolerance=1e-6, Interval=0.01),
    Documentation(info="<html>
<p>
UIC 540 requires 250 m/s for an emergency brake; the isothermal speed of sound is 290 m/s, and this pipe has no
branches.
The front is the fall by 0.1 bar, half a cell before the end of 600 m.
</p>
</html>"));
end PipeFront;
