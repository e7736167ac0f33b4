within RailBraking.Validation;
model EnergyOfAConsist "Energy balance of coupled cars: kinetic energy becomes heat and work"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-5);

  Plants.Consist train(
    cars=2, start_speed=50/3.6, m_wheelset={14e3, 14e3, 14e3, 14e3, 10e3, 10e3, 10e3, 10e3}, c_coupler=1e5,
    slack_coupler=0.02) "Train on a wet rail";
  final parameter Types.Energy E = 96000*(50/3.6)^2/2 + 880*(50/3.6/0.42)^2/2 "Energy at the start";
equation
  train.mu0 = {0.10, 0.11, 0.12, 0.13, 0.13, 0.13, 0.13, 0.13};
  train.track_force = 2000;
  train.car_track_force = {3000, -3000};
  train.pressure_command = {3e5, 3e5, 3e5, 3e5, 1e5, 1e5, 1e5, 1e5};
  error = (train.kinetic_energy + train.contact_heat + train.pad_heat + train.resistance_work + train.coupler_work)/E
    - 1;
  annotation (
    experiment(StopTime=20, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>
The leading car brakes, the other runs into it through the slack; some wheelsets lock. <code>coupler_work</code>
includes the energy that couplers store and dissipate.
</p>
</html>"));
end EnergyOfAConsist;
