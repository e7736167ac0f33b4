within RailBraking.Validation;
model FlashTemperature "Temperature of a contact in fast motion and at rest by closed forms"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=2e-3);

  parameter Types.Length a = 5.8e-3 "Radius of the contact";
  parameter Types.HeatConductivity k = 50 "Heat conductivity of steel";
  parameter Types.Density rho = 7850 "Density of steel";
  parameter Types.SpecificHeat c_p = 450 "Specific heat capacity of steel";
  parameter Types.Velocity V = 20 "Speed of the contact over the body";
  final parameter Types.Area A = 3.14159265358979*a^2 "Area of the contact";
  final parameter Types.ThermalResistance band = 4/3*sqrt(2*a/(3.14159265358979*k*rho*c_p*V))/A
    "Mean under a band of the length 2 a, two thirds of the greatest temperature";
  final parameter Types.ThermalResistance circle_at_rest = 8*a/(3*3.14159265358979*k)/A "Mean under a circle at rest";
  final parameter Types.Ratio strips = 1.437738/(3.14159265358979/2)
    "Mean over the circle's strips over that of the longest: B(1/2, 7/4)/B(1/2, 3/2)";
  Types.Ratio fast "Deviation in fast motion";
  Types.Ratio slow "Deviation at rest";
equation
  fast = Contact.flashResistance(a, a, V, k, rho, c_p)/(strips*band) - 1;
  slow = Contact.flashResistance(a, a, 0, k, rho, c_p)/circle_at_rest - 1;
  error = max(abs(fast), abs(slow));
  annotation (
    experiment(StopTime=1, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
Of the error at 20 m/s, 8e-5 is the rest of the diffusion along the motion, 0.658 over twice the P&eacute;clet number
of 4100; the other part is the four digits of the two numbers.
</p>
</html>"));
end FlashTemperature;
