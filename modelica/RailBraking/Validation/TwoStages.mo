within RailBraking.Validation;
model TwoStages "Position R brakes high above the changeover and low below it, with hysteresis"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-3);

  constant Types.Pressure p_max = 3.8e5 "Cylinder pressure of the high stage";
  constant Types.Time t_slow = 20 "When the vehicle begins to slow down";
  constant Types.Time t_fast = 60 "When it begins to gain speed again";
  Pneumatics.BrakePipe pipe(n=1, length={26.4}) "Brake pipe of one coach";
  Pneumatics.DriversBrakeValve valve "Valve";
  Pneumatics.Reservoir main(V=1, p_start=9e5) "Main reservoir";
  Pneumatics.Reservoir auxiliary(V=0.1, p_start=5e5) "Auxiliary reservoir";
  Pneumatics.TwoStageDistributor distributor(p_max=p_max, share_low=0.45) "In position R";
  Types.Velocity v "Speed: 80 km/h, down to 40 km/h at 1 m/s a second, and up again";
  Types.Time low(start=0, fixed=true) "Time in the low stage since braking has built up";
  Types.Ratio settled "Cylinder pressure over that of its stage, minus one, long after a changeover";
protected
  constant Types.Acceleration slope = 1 "Of the speed";
  constant Types.Time t_down = t_slow + (80 - 50)/3.6/slope "Time at which it passes 50 km/h";
  constant Types.Time t_up = t_fast + (70 - 40)/3.6/slope "Time at which it passes 70 km/h";
equation
  connect(main.port, valve.supply);
  connect(valve.pipe, pipe.front);
  connect(pipe.branch[1], distributor.pipe);
  connect(auxiliary.port, distributor.supply);
  valve.demand = if time < 1 then 5e5 else 0;
  v = if time < t_fast then max(80/3.6 - slope*max(time - t_slow, 0), 40/3.6)
    else min(40/3.6 + slope*(time - t_fast), 80/3.6);
  distributor.speed = v;
  der(low) = if time > 10 and not distributor.high then 1 else 0;
  settled = if time < 15 then 0 elseif time < t_down then distributor.pressure/p_max - 1
    elseif time < t_down + 5 then 0 elseif time < t_up then distributor.pressure/(0.45*p_max) - 1
    elseif time < t_up + 5 then 0 else distributor.pressure/p_max - 1;
  error = abs(settled) + (if time < t_up + 5 then 0 else abs(low/(t_up - t_down) - 1));
  annotation (
    experiment(StopTime=80, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
Full pressure down to 50 km/h, 45 % of it from there on and up to 70 km/h, full pressure again: five seconds after a
changeover the pressure is that of the stage, and the time in the low stage is that between the two speeds.
</p>
</html>"));
end TwoStages;
