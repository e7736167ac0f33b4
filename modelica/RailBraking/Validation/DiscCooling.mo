within RailBraking.Validation;
model DiscCooling "A disc cools with its time constant"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-5);

  Friction.Disc disc(G=1e7, T_start=500) "Disc, both nodes tied to each other";
equation
  disc.heat_flow = 0;
  disc.speed = 20;
  error = (disc.temperature - 293.15 - (500 - 293.15)*exp(-(20 + 2.5*20)*time/(110*500)))/200;
  annotation (
    experiment(StopTime=600, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>hA = 20 + 2.5 v; with a large conductance inside, both nodes are one.</p>
</html>"));
end DiscCooling;
