within RailBraking.Validation;
model HotContact "Friction of a hot contact, and the balance of a tread that only the rail cools"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-4);

  parameter Types.Velocity v = 20 "Speed";
  parameter Types.Ratio s = 0.9 "Slip, far beyond the maximum of adhesion";
  parameter Types.Ratio mu0 = 0.3 "Friction at the temperature of the rail";
  parameter Types.Force load = 137e3 "Load of the wheelset";
  parameter Types.Length r = 0.38 "Rolling radius of the wheels";
  parameter Types.Mass m = 40 "Mass of each rim";
  parameter Types.HeatConductivity k = 50 "Heat conductivity of steel";
  parameter Types.Density rho = 7850 "Density of steel";
  parameter Types.SpecificHeat c_p = 450 "Specific heat capacity of steel";
  parameter Types.Temperature T_rail = 293.15 "Temperature of the rail";
  parameter Types.TemperatureDifference rise = 100 "Temperature of the hot treads at the start, above the rail";
  Contact.HeatedContact sliding(
    r=r, curve=Data.CreepCurve(k_A=1, k_S=1, A=1, B=0), tread(G_rest=0, G_speed=0)) "Sliding contacts";
  Contact.HeatedContact rolling(
    r=r, curve=Data.CreepCurve(k_A=1, k_S=1, A=1, B=0), temperature_loss=0,
    tread(G_rest=0, G_speed=0, m=m, T_start=T_rail + rise)) "Rolling wheels with hot treads";
  final parameter Types.Length a = Contact.semiAxis(r, 0.30, 2.1e11, 0.28)*(load/2)^(1/3)
    "Semi-axis along the track";
  final parameter Types.Area A = 3.14159265358979*a^2*(0.30/r)^(2/3) "Area of a contact";
  final parameter Types.HeatConductance chill = A*sqrt(k*rho*c_p*v/(2*a))*sqrt(3.14159265358979)/(4/3*0.91529)/2
    "Heat flow from a hot tread into the rail, a kelvin, by equal mean temperatures in fast motion";
  Types.Ratio linear "Deviation of the friction from the linear law at the temperature of the contact";
  Types.Ratio cooling "Deviation of the tread from an exponential of the chill";
equation
  sliding.v = v;
  sliding.w = (1 - s)*v/r;
  sliding.load = load;
  sliding.mu0 = mu0;
  rolling.v = v;
  rolling.w = v/r;
  rolling.load = load;
  rolling.mu0 = mu0;
  linear = sliding.alpha/(mu0*(1 - sliding.temperature_loss*(sliding.T_contact - T_rail))) - 1;
  cooling = (rolling.tread.temperature - T_rail)/(rise*exp(-chill/(m*c_p)*time)) - 1;
  error = max(abs(linear), abs(cooling));
  annotation (
    experiment(StopTime=60, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
The contact slides everywhere but for &epsilon;<sup>-3</sup>, so that the force is friction times load and the closed
form of warmFriction meets the linear law at the temperature computed from the heat. The tread cools through the rail as
exp(-chill t/(m c_p)).
</p>
</html>"));
end HotContact;
