within ForeignTrain;
block Train "A point mass on six axles in four groups"
  parameter Real mass(final unit="t", min=1) = 84 "Mass of the train";
  parameter Real axle_inertia(final unit="kg.m2", min=1) = 111 "Moment of inertia that turns with one axle";
  parameter Real wheel_diameter(final unit="mm", min=100) = 760 "Diameter of the wheels";
  parameter Real brake_constant(final unit="kN.m/bar", min=0) = 1.9 "Brake moment on one axle for each bar";
  parameter Real fill_time(final unit="s", min=1e-3) = 0.15 "Time constant of the cylinders";
  parameter Real creep_peak(final unit="1", min=1e-3) = 0.06 "Creep at which the rail gives most";
  parameter Real shape(final unit="1", min=1, max=2) = 1.5 "Shape of the creep curve";
  parameter Real v_small(final unit="m/s", min=1e-3) = 0.3 "Speed below which the creep is regularised";
  parameter Real w_small(final unit="rad/s", min=1e-3) = 0.3 "Angular velocity below which brakes let go gradually";
  parameter Real v0(final unit="km/h", min=0) = 80 "Speed at the start";
  final parameter Real axles[4](each final unit="1") = {2, 1, 1, 2} "Axles of each group";
  input Real demand[4](each final unit="bar", each start=0) "Pressure asked of the cylinders of each group";
  input Real rail_grip[6](each final unit="1", each start=0.1) "Friction that the rail offers each axle";
  input Real drag(final unit="kN", start=0) "Force of hills and curves, holding back when positive";
  output Real velocity(final unit="km/h") "Speed of the train";
  output Real odometer(final unit="km") "Distance since the start";
  output Real retardation(final unit="m/s2") "Retardation, positive when braking";
  output Real axle_speed[4](each final unit="rev/min") "Speed of rotation of each group";
  output Real creep[4](each final unit="1") "Creep of each group, negative when braking";
  output Real used_grip[6](each final unit="1") "Friction used at each axle, negative when braking";
  output Real axle_load[6](each final unit="kN") "Load of each axle";
  output Real cylinder[4](each final unit="bar") "Cylinder pressure of each group";
  output Real brake_moment[4](each final unit="kN.m") "Moment of the brakes on each group";
  output Boolean blocked[4] "= true, if the group hardly turns while the train moves";
  Real s(final unit="m", start=0, fixed=true, nominal=1) "Distance";
  Real v(final unit="m/s", start=v0/3.6, fixed=true, nominal=1) "Speed";
  Real w[4](each final unit="rad/s", each start=v0/3.6/(wheel_diameter/2000), each fixed=true,
    each nominal=1) "Angular velocities";
  Real p[4](each final unit="bar", each start=0, each fixed=true, each nominal=1) "Cylinder pressures";
protected
  Real r(final unit="m") = wheel_diameter/2000 "Radius of the wheels";
  Real axle_creep[6](each final unit="1") "Creep of each axle";
  Real pull[6](each final unit="kN") "Force of the rail on each axle, backward positive";
  Real group_pull[4](each final unit="kN") "The same for each group";
equation
  der(s) = v;
  mass*der(v) = -sum(pull) - drag;
  for i in 1:4 loop
    fill_time*der(p[i]) = demand[i] - p[i];
    creep[i] = (r*w[i] - v)/sqrt(v^2 + v_small^2);
    brake_moment[i] = axles[i]*brake_constant*p[i]*tanh(w[i]/w_small);
    axles[i]*axle_inertia*der(w[i]) = 1000*(r*group_pull[i] - brake_moment[i]);
    axle_speed[i] = rpm*w[i];
    cylinder[i] = p[i];
    blocked[i] = w[i] < w_small and v > 1;
  end for;
  for i in 1:6 loop
    axle_load[i] = mass*g/6;
    used_grip[i] = magicFormula(axle_creep[i], rail_grip[i], creep_peak, shape);
    pull[i] = -used_grip[i]*axle_load[i];
  end for;
  axle_creep = {creep[1], creep[1], creep[2], creep[3], creep[4], creep[4]};
  group_pull[1] = pull[1] + pull[2];
  group_pull[2] = pull[3];
  group_pull[3] = pull[4];
  group_pull[4] = pull[5] + pull[6];
  velocity = 3.6*v;
  odometer = s/1000;
  retardation = -der(v);
  annotation (Documentation(info="<html>
<p>
Tonnes times metres a second squared are kilonewtons, so the equation of motion needs no factor.
</p>
<h4>Limitations</h4>
<p>
No suspension and no load transfer, no running resistance but <code>drag</code>, brakes that do not fade. Below
<code>v_small</code> the train creeps to rest instead of stopping, and a blocked group turns slowly.
</p>
</html>"));
end Train;
