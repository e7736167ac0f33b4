within RailBraking.Validation;
model SlackRunsIn "A car that runs into another through the slack separates as after an elastic impact"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-4);

  parameter Types.Mass m1 = 40e3 "Mass of the leading car";
  parameter Types.Mass m2 = 20e3 "Mass of the car behind";
  parameter Types.Velocity v1 = 5 "Speed of the leading car";
  parameter Types.Velocity v2 = 5.2 "Speed of the car behind";
  parameter Types.Stiffness k = 2e7 "Stiffness of the coupler";
  parameter Types.Length slack = 0.08 "Slack, half of which is run in first";
  final parameter Types.Velocity v_m = (m1*v1 + m2*v2)/(m1 + m2) "Speed of the centre of gravity";
  final parameter Types.Time t_half = 3.14159265358979*sqrt(m1*m2/(m1 + m2)/k) "Duration of the impact";
  Components.CarBody leading(m=m1, start_speed=v1, drag(c_drag=0)) "Leading car";
  Components.CarBody trailing(m=m2, start_speed=v2, drag(c_drag=0)) "Car behind";
  Components.Coupler coupler(k=k, c=0, slack=slack) "Coupler";
  Types.Ratio momentum "Deviation of the momentum";
  Types.Ratio speeds "Deviation of the speed of the car behind, before and after the impact";
equation
  leading.track_force = 0;
  leading.standstill = false;
  trailing.track_force = 0;
  trailing.standstill = false;
  connect(leading.rear, coupler.front);
  connect(coupler.rear, trailing.front);
  momentum = (m1*leading.v + m2*trailing.v)/((m1 + m2)*v_m) - 1;
  speeds = if time < 0.15 then trailing.v/v2 - 1
    elseif time > 0.25 + t_half and time < 0.5 then trailing.v/(2*v_m - v2) - 1 else 0;
  error = 1e3*abs(momentum) + abs(speeds);
  annotation (
    experiment(StopTime=0.5, Tolerance=1e-8, Interval=0.005),
    Documentation(info="<html>
<p>The slack closes after slack/2/(v2 - v1) = 0.2 s; the impact lasts half a period; momentum is conserved throughout,
and
afterwards each car has 2 v_m - v.</p>
</html>"));
end SlackRunsIn;
