within RailBraking.Validation;
model HeatOfASlide "Slip power becomes heat of the wheel, heat of the rail and removal of the film"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-5);

  parameter Types.Velocity v = 20 "Speed";
  parameter Types.Ratio s = 0.3 "Slip";
  parameter Types.Length r = 0.38 "Rolling radius of the wheels";
  parameter Types.Mass m = 40 "Mass of each rim";
  parameter Types.SpecificHeat c_p = 450 "Specific heat capacity of steel";
  parameter Types.Temperature T_start = 293.15 "Temperature of rail, air and rims at the start";
  parameter Types.Energy E = 1e6 "Size of the energies";
  Contact.CleaningContact contact(
    r=r, curve=Data.CreepCurve(k_A=0.3, k_S=0.1, A=0.4, B=0.6), removal_share=0.05, pad_power=20e3,
    c_steel=c_p, T_rail=T_start,
    tread(m=m, G_rest=50)) "Sliding contacts under tread brakes";
  Types.Energy slid(start=0, fixed=true) "Work of the slip";
  Types.Energy given(start=0, fixed=true) "Heat of the pads";
  Types.Energy railed(start=0, fixed=true) "Heat in the rails";
  Types.Energy removed(start=0, fixed=true) "Work of removal";
  Types.Energy cooled(start=0, fixed=true) "Heat given to the air";
  Types.Energy stored "Heat stored in both rims";
equation
  contact.v = v;
  contact.w = (1 - s)*v/r;
  contact.load = 137e3;
  contact.mu0 = 0.1;
  der(slid) = contact.F*s*v;
  der(given) = contact.pad_power;
  der(railed) = contact.heat_rail;
  der(removed) = contact.removal_power;
  der(cooled) = 2*contact.tread.cooling;
  stored = 2*m*c_p*(contact.tread.temperature - T_start);
  error = (slid + given - railed - removed - cooled - stored)/E;
  annotation (
    experiment(StopTime=20, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>The error is over a megajoule, what some ten seconds of this slide dissipate; it is that of the solver.</p>
</html>"));
end HeatOfASlide;
