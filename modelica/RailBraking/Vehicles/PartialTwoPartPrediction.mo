within RailBraking.Vehicles;
partial block PartialTwoPartPrediction "Common parts of the prediction models of the two-part train"
  extends Icons.Vehicle;
  extends PartialBodyPrediction(final m=sum(m_wheelset), v(start=start_speed));
  extends PartialPrediction(
    final n_groups=4,
    final m_group={
      m_wheelset[1] + m_wheelset[2], m_wheelset[3], m_wheelset[4], m_wheelset[5] + m_wheelset[6]},
    J={222, 209, 209, 222}, n_units={3, 2, 2, 3}, r_friction={0.235, 0.220, 0.220, 0.235},
    final radius=fill(r_wheel, 4),
    final f_resistance=fill(
      Components.bearingFriction(mu_bearing, r_bearing, r_wheel) + e_rolling/r_wheel, 4),
    w(each start=start_speed/r_wheel), mu_b(start=mu_b_start), alpha(start=alpha_start));
  parameter Types.Velocity start_speed(min=0) = 80/3.6 "Speed at the start";
  parameter Types.Ratio mu_b_start[4] = {0.35, 0.35, 0.35, 0.35} "Pad friction at the start";
  parameter Types.Ratio alpha_start[4] = {0, 0, 0, 0} "Adhesion of each group at the start";
  parameter Types.Mass m_wheelset[6](each min=1e-3) = {13400, 14100, 14500, 14500, 14100, 13400}
    "Mass that each wheelset carries on the rail, including its own";
  parameter Types.Length r_wheel(min=1e-3) = 0.38 "Rolling radius of all groups";
  parameter Types.Area A_piston(min=1e-6) = 0.0324 "Area of a piston";
  parameter Types.Ratio i_rigging(min=1e-6) = 6 "Force of both pads over force of the piston";
  parameter Types.Ratio eta_rigging(min=0, max=1) = 0.95 "Efficiency of the rigging";
  parameter Types.Force F_spring = 1200 "Force of return spring and slack adjuster";
  Interfaces.RealInput cylinder_pressure[4](each final unit="Pa", each start=0)
    "Cylinder pressure of each group"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput track_force(final unit="N", start=0) "Force of gradient and curve, forward"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));
  Interfaces.RealOutput speed(final unit="m/s") = v "Speed of the train"
    annotation(Placement(transformation(extent={{100, 65}, {120, 85}})));
  Interfaces.RealOutput wheelset_speed[4](each final unit="rad/s") = w "Angular velocity of each group"
    annotation(Placement(transformation(extent={{100, 15}, {120, 35}})));
  Interfaces.RealOutput deflection[2*n_bogies](each final unit="m") = dz
    "Deflection of the primary suspension, change from static, compression positive"
    annotation(Placement(transformation(extent={{100, -35}, {120, -15}})));
  Interfaces.RealOutput acceleration(final unit="m/s2") = a "Acceleration of the train"
    annotation(Placement(transformation(extent={{100, -85}, {120, -65}})));
equation
  for i in 1:4 loop
    pad_force[i] = Pneumatics.padForce(cylinder_pressure[i], A_piston, i_rigging, eta_rigging, F_spring);
  end for;
  train_acceleration = a;
  thrust = track_force - sum(F);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -40}, {-30, 30}, {20, 0}, {80, 50}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The data of the two-part train for <a href=\"modelica://RailBraking.Vehicles.PartialPrediction\">PartialPrediction</a>:
four groups, of two wheelsets each at both ends.
</p>
<h4>Limitations</h4>
<p>
Those of <a href=\"modelica://RailBraking.Vehicles.PartialPrediction\">PartialPrediction</a> and of
<a href=\"modelica://RailBraking.Vehicles.PartialBodyPrediction\">PartialBodyPrediction</a>. One
rolling radius for all groups: the filter attributes differences to slip.
</p>
</html>"));
end PartialTwoPartPrediction;
