within RailBraking.Validation;
model EddyCurrentLimits "An eddy-current brake has its maximum at its own speed, and fades out"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-3);

  Components.EddyCurrentBrake brake(F_max=20e3, v_peak=20, v_full=14, v_end=10, T=1e-3) "Brake";
  constant Types.Acceleration a = 1 "Deceleration";
  Types.Velocity v "Speed, falling evenly";
  Types.Force exact "Closed form";
  Types.Energy braked(start=0, fixed=true) "Work until the fade-out";
  Types.Energy work_exact "Closed form: the integral of 2 F v_peak v^2/(v_peak^2 + v^2) over v";
equation
  v = 60 - a*time;
  brake.demand = 1e9;
  brake.speed = v;
  exact = 20e3*2/(v/20 + 20/v)*(if v > 14 then 1 elseif v > 10 then (v - 10)/4 else 0);
  der(braked) = if v > 14 then brake.force*v else 0;
  work_exact = 2*20e3*20*(60 - 14 - 20*(atan(60/20) - atan(14/20)));
  error = if time < 0.02 then 0 elseif time < 54.99 then (brake.force - exact)/20e3
    else (braked - work_exact)/work_exact;
  annotation (
    experiment(StopTime=55, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>While the speed falls by 1 m/s&sup2;: the force to the lag of 1 ms, at the end its work until the fade-out.</p>
</html>"));
end EddyCurrentLimits;
