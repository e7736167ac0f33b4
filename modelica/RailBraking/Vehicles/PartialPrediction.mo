within RailBraking.Vehicles;
partial block PartialPrediction "Any number of wheelsets and bogies, as modelled by an estimator"
  extends Icons.Vehicle;
  parameter Integer n_groups(min=1) = 1 "Number of groups of wheelsets that turn as one" annotation(Evaluate=true);
  parameter Integer n_bogies(min=0) = 0 "Number of bogies of two wheelsets on a suspension" annotation(Evaluate=true);
  parameter Integer group_of_wheelset[2*n_bogies] = fill(1, 2*n_bogies)
    "Group of each wheelset of these bogies, leading first" annotation(Evaluate=true);
  parameter Types.Mass m_group[n_groups](each min=1e-3, each start=15e3)
    "Mass that each group carries on the rail, including its own";
  parameter Types.Inertia J[n_groups](each min=1e-3, each start=120) "Inertia of each group about its axles";
  parameter Types.Ratio n_units[n_groups](each min=0, each start=2) "Number of brake units of each group";
  parameter Types.Length r_friction[n_groups](each min=1e-3, each start=0.25) "Friction radius of the pads";
  parameter Types.Ratio mu_bearing(min=1e-9) = 0.0018 "Friction coefficient of the axle bearings";
  parameter Types.Length r_bearing(min=1e-9) = 0.065 "Radius of the axle bearings";
  parameter Types.Length e_rolling = 0.0004 "Lever arm of the rolling resistance";
  parameter Types.Mass m_unsprung[2*n_bogies](each min=0, each start=1500) "Mass of each wheelset alone";
  parameter Types.Mass m_frame[n_bogies](each min=1e-3, each start=3500) "Mass of each bogie frame";
  parameter Types.Inertia I_frame[n_bogies](each min=1e-3, each start=2200) "Pitch inertia of each bogie frame";
  parameter Types.Length wheelbase[n_bogies](each min=1e-3, each start=1.9)
    "Distance of the wheelsets of each bogie";
  Types.AngularVelocity w[n_groups](each start=0, each fixed=true, each nominal=1, each stateSelect=StateSelect.always)
    "Angular velocity of each group";
  Types.Ratio mu_b[n_groups](each start=0.35, each fixed=true, each nominal=0.1, each stateSelect=StateSelect.always)
    "Pad friction of each group";
  Types.Ratio alpha[n_groups](each start=0, each fixed=true, each nominal=0.1, each stateSelect=StateSelect.always)
    "Adhesion of each group";
  Types.Length dz[2*n_bogies](each start=0, each fixed=true, each nominal=1e-3, each stateSelect=StateSelect.always)
    "Deflection of the primary suspension over each wheelset, change from static, compression positive";
  Types.Velocity ddz[2*n_bogies](each start=0, each fixed=true, each nominal=1e-2, each stateSelect=StateSelect.always)
    "Rate of the deflection";
protected
  Types.Length radius[n_groups] "Rolling radius of each group";
  Types.Length frame_height[n_bogies] "Height of each frame's centre of gravity over the rail";
  Types.Length rod_height[n_bogies] "Height of each traction rod over the rail";
  Types.Stiffness stiffness[n_bogies] "Stiffness of the primary suspension over one wheelset";
  Types.Damping damping[n_bogies] "Damping of the primary suspension over one wheelset";
  Types.Acceleration train_acceleration "Acceleration of the train";
  Types.Force pad_force[n_groups] "Normal force of both pads of one unit";
  Types.Ratio f_resistance[n_groups] "Bearing and rolling resistance at the rim over load";
  Types.Force static[n_groups] = g*m_group "Static load of each group on the rail";
  Types.Force load[n_groups] "Load of each group on the rail";
  Types.Force F[n_groups] "Braking force of the track on each group";
  Types.Torque torque[n_groups] "Brake torque on each group";
  Types.Force spring[2*n_bogies] "Spring and damper force over each wheelset, change from static";
  Types.Force F_bogie[n_bogies] "Braking force of the track on each bogie";
  Types.Torque torque_bogie[n_bogies] "Brake torque of each bogie";
  Types.Length axle_height[n_bogies] "Height of the axles of each bogie over the rail";
  Types.Torque tipping[n_bogies] "Torque that pitches each frame nose-down, without springs";
equation
  for i in 1:n_groups loop
    load[i] = groupLoad(static[i], spring, group_of_wheelset, i);
    F[i] = alpha[i]*load[i];
    torque[i] = n_units[i]*mu_b[i]*r_friction[i]*pad_force[i];
    J[i]*der(w[i]) = radius[i]*(F[i] - f_resistance[i]*load[i]) - torque[i];
    der(mu_b[i]) = 0;
    der(alpha[i]) = 0;
  end for;
  der(dz) = ddz;
  for i in 1:n_bogies loop
    spring[2*i - 1] = stiffness[i]*dz[2*i - 1] + damping[i]*ddz[2*i - 1];
    spring[2*i] = stiffness[i]*dz[2*i] + damping[i]*ddz[2*i];
    F_bogie[i] = if group_of_wheelset[2*i - 1] == group_of_wheelset[2*i] then F[group_of_wheelset[2*i]]
      else F[group_of_wheelset[2*i - 1]] + F[group_of_wheelset[2*i]];
    torque_bogie[i] = if group_of_wheelset[2*i - 1] == group_of_wheelset[2*i] then torque[group_of_wheelset[2*i]]
      else torque[group_of_wheelset[2*i - 1]] + torque[group_of_wheelset[2*i]];
    axle_height[i] = if group_of_wheelset[2*i - 1] == group_of_wheelset[2*i] then radius[group_of_wheelset[2*i]]
      else (radius[group_of_wheelset[2*i - 1]] + radius[group_of_wheelset[2*i]])/2;
    tipping[i] = Components.frameTorque(
      F_bogie[i], torque_bogie[i], train_acceleration, m_unsprung[2*i - 1] + m_unsprung[2*i], m_frame[i],
      frame_height[i], rod_height[i], axle_height[i]);
    der(ddz[2*i - 1]) = Components.deflectionAcceleration(
      tipping[i], spring[2*i - 1], spring[2*i], m_frame[i], I_frame[i], wheelbase[i]/2);
    der(ddz[2*i]) = Components.deflectionAcceleration(
      tipping[i], spring[2*i], spring[2*i - 1], m_frame[i], I_frame[i], -wheelbase[i]/2);
  end for;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -40}, {-30, 30}, {20, 0}, {80, 50}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Pad friction and adhesion are states without dynamics: only readings change them. Therefore the
prediction has no contact law and is not stiff. In braking, load moves from the rear to the front
wheelset of a bogie; the frame bounces and pitches. The adhesion of a group is that of all its
wheelsets.
</p>
<p>
Extending classes define radii, riggings and suspensions, once for the train or for each group and
bogie, and the acceleration.
</p>
<h4>Limitations</h4>
<p>
Meant for a moving train: at rest the brake torque would turn the wheels backwards. The load of
wheelsets without a bogie is static: a load transfer by braking appears as adhesion in the estimate.
All wheelsets of a group belong to the same bogie, or to none.
Otherwise those of <a href=\"modelica://RailBraking.Components.deflectionAcceleration\">deflectionAcceleration</a>.
</p>
</html>"));
end PartialPrediction;
