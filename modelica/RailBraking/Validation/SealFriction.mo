within RailBraking.Validation;
model SealFriction "The friction of the seal changes the pad force by the same amount at any pressure"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-3);

  parameter Types.Pressure p_seal = 5e3 "Pressure that overcomes the preload of the seal";
  Pneumatics.HystereticRigging rigging(
    A_piston=0.0324, i_rigging=6, eta_rigging=0.95, F_spring=1200, hysteresis=0, p_reverse=1e4, p_seal=p_seal)
    "Rigging with friction of the seal";
  Pneumatics.Rigging frictionless(A_piston=0.0324, i_rigging=6, eta_rigging=0.95, F_spring=1200) "Rigging without";
  Types.Pressure p(start=0, fixed=true) "Pressure, rising and falling";
  Types.Force friction "Friction at the pads, positive when applying";
protected
  Types.Pressure turned "Change of pressure since the last reversal";
  Types.Ratio direction "Friction over its limit";
equation
  der(p) = if time < 2 then 1.5e5 else -1.5e5;
  rigging.pressure = p;
  frictionless.pressure = p;
  friction = frictionless.pad_force - rigging.pad_force;
  turned = if time < 2 then p else 3e5 - p;
  direction = if time < 2 then 1 - exp(-turned/1e4) else 2*exp(-turned/1e4) - 1;
  error = if p < 0.8e5 then 0 else friction/(0.95*6*0.0324*p_seal) - direction;
  annotation (
    experiment(StopTime=3.4, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
Friction starts at rest and has the limit 0.95 &middot; 6 &middot; A_piston p_seal at the pads. It approaches this
limit as 1 - exp(-p/p_reverse); after a reversal at its limit it is 2 exp(-&Delta;p/p_reverse) - 1 times the limit.
</p>
</html>"));
end SealFriction;
