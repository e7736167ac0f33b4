within RailBraking.Validation;
model ValveTimes "Cylinders fill and vent with their dead times and time constants"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-5);

  Pneumatics.ValveCylinder cylinder(
    p_max=3.4e5, V=6e-3, leak=0, T_fill=0.4, T_vent=0.5, rate_choked=1e7, dead_fill=0.05, dead_vent=0.04) "Cylinder";
  Types.Pressure p_exact "Closed form";
equation
  cylinder.command = if time < 0.9995 then 0 elseif time < 1.9995 then 1 elseif time < 2.9995 then 0 else -1;
  p_exact = if time < 1.0505 then 0 elseif time < 2.0505 then 3.4e5*(1 - exp(-(time - 1.0505)/0.4))
    elseif time < 3.0405 then 3.4e5*(1 - exp(-1/0.4)) else 3.4e5*(1 - exp(-1/0.4))*exp(-(time - 3.0405)/0.5);
  error = (cylinder.pressure - p_exact)/3.4e5;
  annotation (
    experiment(StopTime=4, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>The commands change 1 ms before a sample of the delay, so that dead times count from the sample.</p>
</html>"));
end ValveTimes;
