within RailBraking.Validation;
model ElectrodynamicLimits "An electrodynamic brake gives constant force, then constant power, and fades out"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-3);

  Components.ElectrodynamicBrake brake(F_max=60e3, P_max=9e5, v_full=3, v_end=1, T=1e-3) "Brake";
  constant Types.Acceleration a = 1 "Deceleration";
  Types.Velocity v "Speed, falling evenly";
  Types.Force exact "Closed form";
  Types.Energy braked(start=0, fixed=true) "Work over the deceleration of 1 m/s2";
  Types.Energy work_exact "Closed form at standstill";
equation
  v = 40 - a*time;
  brake.demand = 1e9;
  brake.speed = v;
  exact = if v > 15 then 9e5/v elseif v > 3 then 60e3 elseif v > 1 then 30e3*(v - 1) else 0;
  der(braked) = brake.force*v;
  work_exact = 9e5*25 + 60e3*(15^2 - 3^2)/2 + 30e3*((3^3 - 1)/3 - (3^2 - 1)/2);
  error = if time < 0.02 then 0 elseif time < 39.99 then (brake.force - exact)/60e3 else (braked -
work_exact)/work_exact;
  annotation (
    experiment(StopTime=40, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>While the speed falls by 1 m/s&sup2;: the force to the lag of 1 ms, at the end the work of 22.5 MJ at constant
power, and what follows.</p>
</html>"));
end ElectrodynamicLimits;
