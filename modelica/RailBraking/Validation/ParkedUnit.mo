within RailBraking.Validation;
model ParkedUnit "A vented parking cylinder parks, and never adds to the service brake"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-4);

  Pneumatics.ParkingUnit unit(A_piston=0.03, i_rigging=5, eta_rigging=1, F_spring=1000, F_parking=8000, p_release=4e5)
    "Brake unit";
  Types.Force exact "Closed form";
equation
  unit.pressure = if time < 2 then 0 else 3.4e5;
  unit.parking_pressure = 4e5*(if time < 1 then 1 - time else 0);
  exact = 5*(if time < 1 then max(8000*time - 1000, 0) elseif time < 2 then 7000 else 0.03*3.4e5 - 1000);
  error = (unit.pad_force - exact)/35000;
  annotation (
    experiment(StopTime=3, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>First the parking cylinder is vented, then the service cylinder filled: 10.2 kN at its piston win over 8 kN of
the spring.</p>
</html>"));
end ParkedUnit;
