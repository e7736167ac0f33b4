within RailBraking.Validation;
model HotContact "Friction of a hot contact, and the balance of a tread that only the rail cools"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-4);

  parameter Types.Velocity v = 20 "Speed";
  parameter Types.Ratio s = 0.9 "Slip, far beyond the maximum of adhesion";
  parameter Types.Ratio mu0 = 0.3 "Friction at the temperature of the rail";
  Contact.HeatedContact sliding(
    r=0.38, curve=Data.CreepCurve(k_A=1, k_S=1, A=1, B=0), tread(G_rest=0, G_speed=0)) "Sliding contacts";
  Contact.HeatedContact rolling(
    r=0.38, curve=Data.CreepCurve(k_A=1, k_S=1, A=1, B=0), temperature_loss=0,
    tread(G_rest=0, G_speed=0, T_start=393.15)) "Rolling wheels with hot treads";
  final parameter Types.Length a = Contact.semiAxis(0.38, 0.30, 2.1e11, 0.28)*(137e3/2)^(1/3)
    "Semi-axis along the track";
  final parameter Types.Area A = 3.14159265358979*a^2*(0.30/0.38)^(2/3) "Area of a contact";
  final parameter Types.HeatConductance chill = A*sqrt(50*7850*450*v/(2*a))*sqrt(3.14159265358979)/(4/3*0.91529)/2
    "Heat flow from a hot tread into the rail, a kelvin, by equal mean temperatures in fast motion";
  Types.Ratio linear "Deviation of the friction from the linear law at the temperature of the contact";
  Types.Ratio cooling "Deviation of the tread from an exponential of the chill";
equation
  sliding.v = v;
  sliding.w = (1 - s)*v/0.38;
  sliding.load = 137e3;
  sliding.mu0 = mu0;
  rolling.v = v;
  rolling.w = v/0.38;
  rolling.load = 137e3;
  rolling.mu0 = mu0;
  linear = sliding.alpha/(mu0*(1 - sliding.temperature_loss*(sliding.T_contact - 293.15))) - 1;
  cooling = (rolling.tread.temperature - 293.15)/(100*exp(-chill/(40*450)*time)) - 1;
  error = linear + cooling;
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
