within RailBraking.Validation;
model TrainOfComponents "The two-part train from bogies stops as the one written at length"
  extends Interfaces.PartialValidation(tolerance=1e-6);

  FMUs.TwoPartTrain written(speed_start=60/3.6) "Written at length";
  FMUs.ArticulatedTrain built(speed_start=60/3.6) "Made of components";
equation
  written.mu0 = {0.10, 0.11, 0.12, 0.12, 0.13, 0.13};
  written.track_force = 1000;
  written.pressure_command = {1.5e5, 2e5, 2e5, 1.5e5};
  built.mu0 = {0.10, 0.11, 0.12, 0.12, 0.13, 0.13};
  built.track_force = 1000;
  built.pressure_command = {1.5e5, 2e5, 2e5, 1.5e5};
  error = abs(built.distance - written.distance)/100 + abs(built.wheelset_speed[1] - written.wheelset_speed[1])/40
    + abs(built.wheelset_load[3]/written.wheelset_load[3] - 1);
  annotation (
    experiment(StopTime=15, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>Distance, angular velocity and load agree throughout.</p>
</html>"));
end TrainOfComponents;
