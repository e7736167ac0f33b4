within RailBraking.Validation;
model DistributorTimes "Filling and release in positions P and G are within the limits of UIC 540"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1);

  constant Types.Time shortest_fill[2] = {3, 18} "In P and G";
  constant Types.Time longest_fill[2] = {5, 30} "In P and G";
  constant Types.Time shortest_release[2] = {15, 45} "In P and G";
  constant Types.Time longest_release[2] = {20, 60} "In P and G";
  constant Types.Time t_release = 50 "When the pipe is filled again";
  Pneumatics.BrakePipe pipe(n=2, length={26.4, 26.4}) "Brake pipe of two coaches";
  Pneumatics.DriversBrakeValve valve "Valve";
  Pneumatics.Reservoir main(V=1, p_start=9e5) "Main reservoir";
  Pneumatics.Reservoir auxiliary[2](each V=0.1, each p_start=5e5) "Auxiliary reservoirs";
  Pneumatics.Distributor distributor[2](T_fill={4, 24}, T_release={17, 52}) "In P and in G";
  Types.Time filling_time[2](each start=0, each fixed=true) "Between the first pressure and 95 % of the full one";
  Types.Time release_time[2](each start=0, each fixed=true) "Above 0.4 bar after the release";
  Types.Ratio filling[2] "Time of filling, -1 and 1 at its limits";
  Types.Ratio release[2] "Time of release, -1 and 1 at its limits";
equation
  connect(main.port, valve.supply);
  connect(valve.pipe, pipe.front);
  for i in 1:2 loop
    connect(pipe.branch[i], distributor[i].pipe);
    connect(auxiliary[i].port, distributor[i].supply);
    der(filling_time[i]) = if time < t_release and distributor[i].pressure > 1e3
      and distributor[i].pressure < 0.95*3.8e5 then 1 else 0;
    der(release_time[i]) = if time > t_release and distributor[i].pressure > 0.4e5 then 1 else 0;
    filling[i] = (2*filling_time[i] - longest_fill[i] - shortest_fill[i])/(longest_fill[i] - shortest_fill[i]);
    release[i] = (2*release_time[i] - longest_release[i] - shortest_release[i])
      /(longest_release[i] - shortest_release[i]);
  end for;
  valve.demand = if time >= 1 and time < t_release then 0 else 5e5;
  error = if time < 40 then 0 elseif time < 115 then max(abs(filling)) else max(max(abs(filling)), max(abs(release)));
  annotation (
    experiment(StopTime=120, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
Two vehicles whose pipe is vented by an emergency brake and filled again: from the first pressure to 95 % in 3 to 5
s and 18 to 30 s, from the
demand to 0.4 bar in 15 to 20 s and 45 to 60 s.
</p>
</html>"));
end DistributorTimes;
