within RailBraking.Validation;
model LoadProportional "A load valve keeps the deceleration from tare to laden"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-9);

  Pneumatics.LoadValve valve(m_tare=40000, m_laden=50000, share_tare=0.8) "Valve";
  Types.Mass m "Mass, rising with time";
  Types.Pressure p_exact "Closed form";
equation
  m = 35000 + 20000*time;
  valve.load = m;
  valve.demand = 3.8e5;
  p_exact = 3.8e5*(if m < 40000 then 0.8 elseif m < 50000 then m/50000 else 1);
  error = (valve.pressure - p_exact)/3.8e5;
  annotation (
    experiment(StopTime=1, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>With share_tare = m_tare/m_laden, pressure over mass is the same at each load between; beyond, the pressure
stays.</p>
</html>"));
end LoadProportional;
