within RailBraking.Validation;
model DistributorTimes "Filling and release in position P lie within the limits of UIC 540"
  extends Interfaces.PartialValidation(tolerance=1);

  Pneumatics.BrakePipe pipe(n=1, length={26.4}) "Brake pipe of one coach";
  Pneumatics.DriversBrakeValve valve "Valve";
  Pneumatics.Reservoir main(V=1, p_start=9e5) "Main reservoir";
  Pneumatics.Reservoir auxiliary(V=0.1, p_start=5e5) "Auxiliary reservoir";
  Pneumatics.Distributor distributor "In position P";
  Types.Time begin(start=0, fixed=true) "First pressure in the cylinder";
  Types.Time filled(start=0, fixed=true) "95 % of the full pressure";
  Types.Time released(start=0, fixed=true) "0.4 bar again";
  Types.Ratio filling_error "Of the time of filling, 1 at the limits of 3 and 5 s";
  Types.Ratio release_error "Of the time of release, 1 at the limits of 15 and 20 s";
equation
  connect(main.port, valve.supply);
  connect(valve.pipe, pipe.front);
  connect(pipe.branch[1], distributor.pipe);
  connect(auxiliary.port, distributor.supply);
  valve.demand = if time >= 1 and time < 20 then 0 else 5e5;
  when distributor.pressure > 1e3 then
    begin = time;
  end when;
  when distributor.pressure > 0.95*3.8e5 then
    filled = time;
  end when;
  when distributor.pressure < 0.4e5 then
    released = time;
  end when;
  filling_error = if time < 10 then 0 else filled - begin - 4;
  release_error = if time < 42 then 0 else (released - 20 - 17.5)/2.5;
  error = max(abs(filling_error), abs(release_error));
  annotation (
    experiment(StopTime=45, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
One coach whose pipe is vented by an emergency brake and filled again: 3 to 5 s from the first pressure to 95 % and
15 to 20 s from the demand to
0.4 bar.
</p>
</html>"));
end DistributorTimes;
