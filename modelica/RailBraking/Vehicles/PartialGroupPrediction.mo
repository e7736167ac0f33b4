within RailBraking.Vehicles;
partial block PartialGroupPrediction "Groups of wheelsets as an estimator believes them to be, their loads left open"
  parameter Integer n_groups(min=1) = 1 "Number of groups" annotation(Evaluate=true);
  parameter Types.Inertia J[n_groups](each min=1e-3, each start=120) "Inertia of each group about its axles";
  parameter Types.Length r_wheel[n_groups](each min=1e-3, each start=0.46) "Rolling radius of each group";
  parameter Types.Ratio n_units[n_groups](each min=0, each start=2) "Number of brake units of each group";
  parameter Types.Length r_friction[n_groups](each min=1e-3, each start=0.25) "Radius at which the pads rub";
  parameter Types.Area A_piston(min=1e-6) = 0.0324 "Area of a piston";
  parameter Types.Ratio i_rigging(min=1e-6) = 6 "Force of both pads over force of the piston";
  parameter Types.Ratio eta_rigging(min=0, max=1) = 0.95 "Efficiency of the rigging";
  parameter Types.Force F_spring = 1200 "Force of return spring and slack adjuster";
  parameter Types.Ratio mu_bearing(min=1e-9) = 0.0018 "Friction coefficient of the axle bearings";
  parameter Types.Length r_bearing(min=1e-9) = 0.065 "Radius of the axle bearings";
  parameter Types.Length e_rolling = 0.0004 "Lever arm of the rolling resistance";
  Interfaces.RealInput cylinder_pressure[n_groups](each final unit="Pa", each start=0)
    "Pressure in the cylinders of each group"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput acceleration(final unit="m/s2", start=0) "Acceleration of the train"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));
  Interfaces.RealOutput force(final unit="N") = sum(F) "Braking force of the track on all groups together"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  Types.AngularVelocity w[n_groups](each start=0, each fixed=true, each stateSelect=StateSelect.always)
    "Angular velocity of each group";
  Types.Ratio mu_b[n_groups](each start=0.35, each fixed=true, each stateSelect=StateSelect.always)
    "Pad friction of each group";
  Types.Ratio alpha[n_groups](each start=0, each fixed=true, each stateSelect=StateSelect.always)
    "Adhesion of each group";
protected
  Types.Force load[n_groups] "Load of each group on the rail";
  Types.Force F[n_groups] "Braking force of the track on each group";
  Types.Torque torque[n_groups] "Brake torque on each group";
equation
  for i in 1:n_groups loop
    F[i] = alpha[i]*load[i];
    torque[i] = n_units[i]*mu_b[i]*r_friction[i]
      *Pneumatics.padForce(cylinder_pressure[i], A_piston, i_rigging, eta_rigging, F_spring);
    J[i]*der(w[i]) = r_wheel[i]*F[i] - torque[i]
      - r_wheel[i]*(Components.bearingFriction(mu_bearing, r_bearing, r_wheel[i]) + e_rolling/r_wheel[i])*load[i];
    der(mu_b[i]) = 0;
    der(alpha[i]) = 0;
  end for;
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
The part of a train that an estimator can treat by itself once the acceleration of the train is known: speed and
acceleration are all that it shares with the rest. Pad friction and adhesion are states without dynamics: only a reading
moves them. Therefore no contact law is in the prediction, and nothing in it is stiff.
</p>
<h4>Limitations</h4>
<p>Meant for a moving train: at rest the brake torque would turn the wheels backwards.</p>
</html>"));
end PartialGroupPrediction;
