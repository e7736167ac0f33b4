within RailBraking.Vehicles;
partial block PartialConsistPrediction "Wheelsets and bogies of an estimator, each with its own data"
  extends Icons.Vehicle;
  extends PartialPrediction(
    radius=r_wheel, frame_height=h_frame, rod_height=h_rod, stiffness=k_primary, damping=c_primary);
  parameter Types.Length r_wheel[n_groups](each min=1e-3, each start=0.46) "Rolling radius of each group";
  parameter Types.Area A_piston[n_groups](each min=1e-6, each start=0.0324) "Area of a piston";
  parameter Types.Ratio i_rigging[n_groups](each min=1e-6, each start=6)
    "Force of both pads over force of the piston";
  parameter Types.Ratio eta_rigging[n_groups](each min=0, each max=1, each start=0.95)
    "Efficiency of the rigging";
  parameter Types.Force F_spring[n_groups](each start=1200) "Force of return spring and slack adjuster";
  parameter Types.Length h_frame[n_bogies](each start=0.55)
    "Height of each frame's centre of gravity over the rail";
  parameter Types.Length h_rod[n_bogies](each start=0.40) "Height of each traction rod over the rail";
  parameter Types.Stiffness k_primary[n_bogies](each start=2.4e6)
    "Stiffness of the primary suspension over one wheelset";
  parameter Types.Damping c_primary[n_bogies](each start=2.4e4)
    "Damping of the primary suspension over one wheelset";
protected
  Types.Pressure pressure[n_groups] "Cylinder pressure of each group";
equation
  for i in 1:n_groups loop
    f_resistance[i] = Components.bearingFriction(mu_bearing, r_bearing, r_wheel[i]) + e_rolling/r_wheel[i];
    pad_force[i] = Pneumatics.padForce(pressure[i], A_piston[i], i_rigging[i], eta_rigging[i], F_spring[i]);
  end for;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-80, -40}, {-30, 30}, {20, 0}, {80, 50}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Vehicles.PartialPrediction\">PartialPrediction</a>.</p>
</html>"));
end PartialConsistPrediction;
