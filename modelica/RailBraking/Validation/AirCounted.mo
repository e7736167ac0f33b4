within RailBraking.Validation;
model AirCounted "Every filling consumes V p/p_free of free air"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-6);

  Pneumatics.ValveCylinder cylinder(p_max=3.4e5, V=6e-3, leak=0) "Cylinder filled by a valve";
  Pneumatics.IdealCylinder ideal(p_max=3.4e5, V=6e-3) "Cylinder that follows a command";
  Types.Volume air(start=0, fixed=true) "Free air of the first";
  Types.Volume air_ideal(start=0, fixed=true) "Free air of the second";
equation
  cylinder.command = 1;
  ideal.command = if time < 1 then 2e5 elseif time < 2 then 1e5 else 5e5;
  der(air) = cylinder.air_flow;
  der(air_ideal) = ideal.air_flow;
  error = if time < 2.9 then 0 else max({
    abs(air - 6e-3*cylinder.pressure/1.01325e5), abs(air_ideal - 6e-3*(2e5 + 2.4e5)/1.01325e5)})/0.02;
  annotation (
    experiment(StopTime=3, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>The second cylinder is filled, partly vented and filled again to the limit.</p>
</html>"));
end AirCounted;
