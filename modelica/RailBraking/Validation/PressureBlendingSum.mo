within RailBraking.Validation;
model PressureBlendingSum "Friction and dynamic brakes sum to the demand, by valve and across the train"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-9);

  Components.PressureBlending own(n=2, force_per_pressure={0.05, 0.03}, p_spring={0.2e5, 0.4e5}) "By valve";
  Components.PressureBlending common(n=2, across=true, force_per_pressure={0.05, 0.03}, p_spring={0.2e5, 0.4e5})
    "Across the train";
  Types.Force available "Force of the dynamic brake of the first valve";
  Types.Force sum_own "Force of both valves";
  Types.Force sum_common "Force of both valves";
  constant Types.Force demand[2] = {0.05*2.8e5, 0.03*2.6e5} "Of both valves";
equation
  available = 25e3*time;
  own.pressure = {3e5, 3e5};
  common.pressure = {3e5, 3e5};
  own.available = {available, 0};
  common.available = {available, 0};
  own.force = {own.share[1]*available, 0};
  common.force = {common.share[1]*available, 0};
  sum_own = own.force[1] + 0.05*(own.friction[1] - 0.2e5) + 0.03*(own.friction[2] - 0.4e5);
  sum_common = common.force[1] + 0.05*(common.friction[1] - 0.2e5) + 0.03*(common.friction[2] - 0.4e5);
  error = max(max(abs(sum_own - sum(demand)), abs(sum_common - sum(demand))),
    max(abs(own.force[1] - min(available, demand[1])), abs(common.force[1] - min(available, sum(demand)))))/sum(demand);
  annotation (
    experiment(StopTime=1, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
The available dynamic force of one of two valves rises from 0 to 25 kN, beyond the demand of both, 21.8 kN: alone it
takes at most the demand of its own valve, 14 kN; across the train all of it.
</p>
</html>"));
end PressureBlendingSum;
