within RailBraking.Validation;
model CommandDelay "A demand by wire has a dead time and a lag"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-5);

  Pneumatics.ElectropneumaticCommand wire(delay=0.4, T=0.5, T_release=0.3) "Command";
  Types.Pressure p_exact "Closed form";
equation
  wire.demand = if time >= 1 and time < 3 then 3e5 else 0;
  p_exact = if time < 1.4005 then 0 elseif time < 3.4005 then 3e5*(1 - exp(-(time - 1.4005)/0.5))
    else 3e5*(1 - exp(-2/0.5))*exp(-(time - 3.4005)/0.3);
  error = (wire.pressure - p_exact)/3e5;
  annotation (
    experiment(StopTime=5, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>The demand changes half a millisecond before a sample of the delay line, from which the dead time counts.</p>
</html>"));
end CommandDelay;
