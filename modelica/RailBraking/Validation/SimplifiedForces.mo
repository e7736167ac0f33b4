within RailBraking.Validation;
model SimplifiedForces "The simplified theory has the linear stiffness at small slip and full friction at large slip"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-3);

  parameter Types.Ratio slip = 1e-6 "Small slip, at which 2e-4 of the stiffness is lost";
  parameter Types.Force load = 137e3 "Load of the wheelset";
  parameter Types.Ratio mu0 = 0.3 "Friction, independent of the slip speed";
  FMUs.SimplifiedContactPoint point(k_A=1, k_S=1, A_falling=1, B_falling=0) "Contact at small slip";
  Contact.SimplifiedContact contact(r=0.38, curve=Data.CreepCurve(k_A=0.3, k_S=0.1, A=1, B=0)) "Locked wheelset";
protected
  final parameter Real factor = Contact.creepFactor(0.38, 0.30, 2.1e11, 0.28) "Slope of epsilon, see creepFactor";
equation
  point.slip = slip;
  point.speed = 20;
  point.load = load;
  point.mu0 = mu0;
  contact.v = 20;
  contact.w = 0;
  contact.load = load;
  contact.mu0 = mu0;
  error = abs(point.adhesion/(4/3.14159265358979*factor*slip/(load/2)^(1/3)) - 1) + abs(contact.alpha/mu0 - 1);
  annotation (
    experiment(StopTime=1, Tolerance=1e-8, Interval=0.05),
    Documentation(info="<html>
<p>By Kalker's linear theory the force of a wheel is G a b c11 slip.</p>
</html>"));
end SimplifiedForces;
