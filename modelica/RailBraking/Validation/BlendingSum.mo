within RailBraking.Validation;
model BlendingSum "Electrodynamic and friction brake sum to the demand, and a slide reduces both"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-6);

  Components.Blending blending(n=3, share={0.5, 0.5, 0}) "Two motored axles and a trailer";
  Components.ElectrodynamicBrake dynamic(F_max=30e3, P_max=6e5, v_full=3, v_end=1, T=0.1) "Of both motored axles";
  Types.Velocity v "Speed, falling evenly";
  Types.Force demand[3] "Force of each axle, after wheel-slide protection";
  Types.Ratio sum_error "Excess of the sum of the forces over the demand";
  Types.Ratio share_error "Excess of the electrodynamic force over the limit of a sliding axle";
equation
  v = max(30 - time, 0);
  blending.demand = {20e3, 20e3, 20e3};
  blending.kept = {1, if time > 18 and time < 22 then 0.25 else 1, 1};
  blending.available = dynamic.available;
  dynamic.demand = blending.dynamic_demand;
  dynamic.speed = v;
  blending.dynamic_force = dynamic.force;
  for i in 1:3 loop
    demand[i] = blending.kept[i]*blending.demand[i];
  end for;
  sum_error = (sum(blending.friction) + dynamic.force - sum(demand))/60e3;
  share_error = if time > 20 and time < 22 then (dynamic.force - 2*demand[2])/60e3
    elseif time > 27.1 then (dynamic.force - 30e3*max(v - 1, 0)/2)/60e3
    elseif time > 24 and time < 26 then (dynamic.force - 30e3)/60e3 else 0;
  error = max(if time > 18 and time < 20 then 0 else abs(sum_error), max(abs(share_error) - 1e-3, 0));
  annotation (
    experiment(StopTime=30, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
Demand 60 kN, of which the electrodynamic brake provides at most 30 kN; while one motored axle is
limited to a quarter, from 18 to 22 s, it provides 10 kN and the friction brake of the other
compensates. In the first two seconds of that the
electrodynamic force still falls, with
its lag of 0.1 s.
</p>
</html>"));
end BlendingSum;
