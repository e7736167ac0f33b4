within RailBraking.Validation;
model EnergyOfAStop "Energy balance of a stop: kinetic energy becomes heat and work"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-6);

  Plants.TwoPartTrain train(start_speed=85/3.6) "Train on a wet rail";
  final parameter Types.Energy E = 84000*(85/3.6)^2/2 + 862*(85/3.6/0.38)^2/2 "Energy at the start";
equation
  train.mu0 = fill(0.12, 6);
  train.track_force = 2000;
  train.pressure_command = {3.4e5, 2e5, 2e5, 3.4e5};
  error = (train.kinetic_energy + train.contact_heat + train.pad_heat + train.resistance_work)/E - 1;
  annotation (
    experiment(StopTime=45, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>The motor bogies lock during the stop: the balance also holds across events.</p>
</html>"));
end EnergyOfAStop;
