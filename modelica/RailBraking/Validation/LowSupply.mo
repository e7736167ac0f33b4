within RailBraking.Validation;
model LowSupply "Cylinders fill to the pressure of a supply that rises slowly"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-5);

  parameter Types.Pressure p_end = 2e5 "Final pressure of the supply, below that of the cylinders";
  parameter Types.Time T_supply = 0.8 "Time constant of the supply";
  parameter Types.Time T_fill = 0.3 "Time constant of the cylinders";
  Pneumatics.PrescribedSupply supply "Supply";
  Pneumatics.SuppliedCylinder cylinder(p_max=3.8e5, V=6e-3, leak=0, T_fill=T_fill, dead_fill=0) "Cylinders";
  Types.Pressure p_exact "Two lags in series";
protected
  Types.Time since "Time that the fill valve has been open";
equation
  supply.pressure = p_end*(1 - exp(-since/T_supply));
  connect(supply.port, cylinder.supply);
  cylinder.command = 1;
  // The valve opens with its first sample.
  since = max(time - 0.0005, 0);
  p_exact = p_end*(1 - (T_supply*exp(-since/T_supply) - T_fill*exp(-since/T_fill))/(T_supply - T_fill));
  error = abs(cylinder.pressure - p_exact)/p_end;
  annotation (
    experiment(StopTime=5, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
The output of an electropneumatic command supplies the cylinders, whose maximum pressure is not reached.
</p>
</html>"));
end LowSupply;
