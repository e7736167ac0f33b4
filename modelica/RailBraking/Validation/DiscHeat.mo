within RailBraking.Validation;
model DiscHeat "The disc keeps the heat of the pads"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-6);

  Friction.Disc disc(G_rest=0, G_speed=0) "Disc without cooling";
equation
  disc.heat_flow = 100e3;
  disc.speed = 20;
  error = ((110 - 12)*500*(disc.temperature - 313.15)
    + 12*500*(disc.temperature_surface - 313.15) - 0.93*100e3*time)/1e6;
  annotation (
    experiment(StopTime=10, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>Seven per cent remain in the pads.</p>
</html>"));
end DiscHeat;
