within RailBraking.Vehicles;
partial block PartialPrediction "What the two prediction models of the two-part train have in common"
  parameter Types.Velocity speed_start(min=0) = 22.222222222222222 "Speed at the start";
  parameter Types.Ratio mu_b_start[4] = {0.35, 0.35, 0.35, 0.35} "Pad friction at the start";
  parameter Types.Ratio alpha_start[4] = {0, 0, 0, 0} "Adhesion of each group at the start";
  parameter Types.Mass m_wheelset[6](each min=1e-3) = {13400, 14100, 14500, 14500, 14100, 13400}
    "Mass that each wheelset carries on the rail, its own included";
  parameter Types.Inertia J[4](each min=1e-3) = {222, 209, 209, 222} "Inertia of each group about its axles";
  parameter Types.Length r_wheel(min=1e-3) = 0.38 "Rolling radius of all groups";
  parameter Types.Ratio n_units[4](each min=0) = {3, 2, 2, 3} "Number of brake units of each group";
  parameter Types.Length r_friction[4](each min=1e-3) = {0.235, 0.220, 0.220, 0.235} "Radius at which the pads rub";
  parameter Types.Area A_piston(min=1e-6) = 0.0324 "Area of a piston";
  parameter Types.Ratio i_rigging(min=1e-6) = 6 "Force of both pads over force of the piston";
  parameter Types.Ratio eta_rigging(min=0, max=1) = 0.95 "Efficiency of the rigging";
  parameter Types.Force F_spring = 1200 "Force of return spring and slack adjuster";
  parameter Types.Ratio mu_bearing(min=1e-9) = 0.0018 "Friction coefficient of the axle bearings";
  parameter Types.Length r_bearing(min=1e-9) = 0.065 "Radius of the axle bearings";
  parameter Types.Length e_rolling = 0.0004 "Lever arm of the rolling resistance";
  parameter Types.Ratio c_drag = 0.9 "Drag coefficient";
  parameter Types.Area A_drag = 10 "Frontal area";
  parameter Types.Density rho_air = 1.2 "Density of the air";

  Interfaces.RealInput cylinder_pressure[4](each final unit="Pa", each start=0)
    "Pressure in the cylinders of each group"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput track_force(final unit="N", start=0) "Force of gradient and curve, forward"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));

  Types.Velocity v(start=speed_start, fixed=true, stateSelect=StateSelect.always) "Speed of the train";
  Types.AngularVelocity w[4](each start=speed_start/r_wheel, each fixed=true, each stateSelect=StateSelect.always)
    "Angular velocity of each group";
  Types.Ratio mu_b[4](start=mu_b_start, each fixed=true, each stateSelect=StateSelect.always)
    "Pad friction of each group";
  Types.Ratio alpha[4](start=alpha_start, each fixed=true, each stateSelect=StateSelect.always)
    "Adhesion of each group";
protected
  final parameter Types.Ratio f_resistance =
    Components.bearingFriction(mu_bearing, r_bearing, r_wheel) + e_rolling/r_wheel
    "Bearing and rolling resistance at the rim over load";
  Types.Acceleration disturbance = 0 "What moves the train and is in no equation of these";
  Types.Force load[4] "Load of each group on the rail";
  Types.Force F[4] "Braking force of the track on each group";
  Types.Torque torque[4] "Brake torque on each group";
equation
  for i in 1:4 loop
    F[i] = alpha[i]*load[i];
    torque[i] = n_units[i]*mu_b[i]*r_friction[i]
      *Pneumatics.padForce(cylinder_pressure[i], A_piston, i_rigging, eta_rigging, F_spring);
    J[i]*der(w[i]) = r_wheel*(F[i] - f_resistance*load[i]) - torque[i];
  end for;
  sum(m_wheelset)*(der(v) - disturbance) = track_force - sum(F) - rho_air/2*c_drag*A_drag*v^2;
  der(mu_b) = zeros(4);
  der(alpha) = zeros(4);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Line(points={{-80, -40}, {-30, 30}, {20, 0}, {80, 50}}, color={0, 0, 127}),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Pad friction and adhesion are states without dynamics: only a reading moves them. Therefore no contact law is in
the prediction, and nothing in it is stiff.
</p>
<h4>Limitations</h4>
<p>
Meant for a moving train: at rest the brake torque would turn the wheels backwards. One rolling radius for all
groups: differences are, to the filter, slip.
</p>
</html>"));
end PartialPrediction;
