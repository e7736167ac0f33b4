within SimpleTrain;
partial block Train "Rigid train of n equal wheelsets, each with a brake of its own"
  parameter Integer n(min=1) = 1 "Number of wheelsets" annotation(Evaluate=true);
  parameter Real wheelsets_per_group[n](each final unit="1")
    "Number of wheelsets that turn as one, leading group first: one in each group";
  parameter Real start_speed(final unit="m/s", min=0) = 30 "Speed at the start";
  parameter Real m_wheelset(final unit="kg", min=1) = 15e3 "Mass that each wheelset carries";
  parameter Real J(final unit="kg.m2", min=1) = 120 "Inertia of each wheelset";
  parameter Real r_wheel(final unit="m", min=0.1) = 0.46 "Rolling radius";
  parameter Real n_units(final unit="1", min=1) = 2 "Brake units of each wheelset";
  parameter Real r_friction(final unit="m", min=1e-3) = 0.24 "Radius at which the pads rub";
  parameter Real p_max(final unit="Pa", min=1) = 3.2e5 "Largest cylinder pressure";
  parameter Real A_piston(final unit="m2", min=1e-6) = 0.0324 "Area of a piston";
  parameter Real i_rigging(final unit="1", min=1e-3) = 5 "Force of both pads over force of the piston";
  parameter Real eta_rigging(final unit="1", min=1e-3, max=1) = 0.95 "Efficiency of the rigging";
  parameter Real F_spring(final unit="N", min=0) = 1200 "Force of the return spring";
  parameter Real T_pressure(final unit="s", min=1e-3) = 0.05 "Time constant of the cylinder pressure";
  parameter Real k_A(final unit="1") = 0.3 "Polach: reduction of the creep stiffness in the area of adhesion";
  parameter Real k_S(final unit="1") = 0.1 "Polach: reduction of the creep stiffness in the area of slip";
  parameter Real A_falling(final unit="1") = 0.4 "Polach: friction at infinite slip speed over maximum friction";
  parameter Real B_falling(final unit="s/m") = 0.2 "Polach: rate at which friction falls with slip speed";

  input Real pressure_command[n](each final unit="Pa", each start=0) "Pressure that the cylinders shall have";
  input Real mu0[n](each final unit="1", each start=0) "Maximum friction of the rail at each wheelset";
  input Real track_force(final unit="N", start=0) "Force of gradient and curve, forward";
  output Real distance(final unit="m") "Distance travelled";
  output Real speed(final unit="m/s") "Speed of the train";
  output Real acceleration(final unit="m/s2") "Acceleration of the train";
  output Real wheelset_speed[n](each final unit="rad/s") "Angular velocity of each wheelset";
  output Real slip[n](each final unit="1") "Slip of each wheelset";
  output Real adhesion[n](each final unit="1") "Adhesion used by each wheelset";
  output Real group_adhesion[n](each final unit="1") "The same, for each group is one wheelset";
  output Real wheelset_load[n](each final unit="N") "Load of each wheelset on the rail";
  output Real cylinder_pressure[n](each final unit="Pa") "Pressure in the cylinders";
  output Real pad_force[n](each final unit="N") "Normal force of both pads of one unit";
  output Real pad_friction[n](each final unit="1") "Friction of the pads";
  output Real brake_torque[n](each final unit="N.m") "Torque of the brake on each wheelset";
  output Boolean locked[n] "= true, if the wheelset does not turn";
  output Boolean standstill "= true, if the train stands";
protected
  RailBraking.Components.TrainBody body(m=n*m_wheelset, start_speed=start_speed) "Mass along the track";
  Axle axle[n](
    each J=J, each r_wheel=r_wheel, each n_units=n_units, each r_friction=r_friction, each p_max=p_max, each A_piston=A_piston,
    each i_rigging=i_rigging, each eta_rigging=eta_rigging, each F_spring=F_spring, each T_pressure=T_pressure,
    each k_A=k_A, each k_S=k_S, each A_falling=A_falling, each B_falling=B_falling, each start_speed=start_speed)
    "Wheelsets with their brakes";
equation
  for i in 1:n loop
    axle[i].pressure_command = pressure_command[i];
    axle[i].mu0 = mu0[i];
    axle[i].load = wheelset_load[i];
    axle[i].speed = speed;
    axle[i].standstill = standstill;
    wheelset_load[i] = m_wheelset*RailBraking.g;
    wheelset_speed[i] = axle[i].w;
    slip[i] = axle[i].slip;
    adhesion[i] = axle[i].force/wheelset_load[i];
    group_adhesion[i] = adhesion[i];
    cylinder_pressure[i] = axle[i].pressure;
    pad_force[i] = axle[i].pad_force;
    pad_friction[i] = axle[i].pad_friction;
    brake_torque[i] = axle[i].torque;
    locked[i] = axle[i].locked;
  end for;
  body.F = sum(axle.force);
  body.track_force = track_force;
  body.capacity = sum(axle.capacity);
  distance = body.s;
  speed = body.v;
  acceleration = body.a;
  standstill = body.standstill;
  annotation (Documentation(info="<html>
<h4>Limitations</h4>
<p>No suspension: loads stay as they are when the train brakes. Forward motion only.</p>
</html>"));
end Train;
