within RailBraking.Vehicles;
partial block PartialLateralWheelset "A conical wheelset free to move sideways and to yaw"
  extends Icons.Vehicle;
  parameter Types.Length r_wheel = 0.5 "Rolling radius of the wheels, centred";
  parameter Types.Length half_gauge = 0.75 "Half of the distance of the contacts";
  parameter Types.Ratio conicity = 0.15 "Change of rolling radius over lateral displacement";
  parameter Types.Mass m_unsprung = 1250 "Mass of the wheelset alone, including the motor";
  parameter Types.Inertia I_yaw = 700 "Yaw inertia of the wheelset";
  parameter Types.RotationalStiffness k_yaw = 5e6 "Yaw stiffness between wheelset and vehicle";
  parameter Types.Mass m_wheelset = 15000 "Mass that the wheelset carries on the rail, including its own";
  parameter Types.Ratio k_A = 1 "Polach: reduction of the creep stiffness in the area of adhesion";
  parameter Types.Ratio k_S = 1 "Polach: reduction of the creep stiffness in the area of slip";
  parameter Types.Length r_rail = 0.30 "Radius of the rail head across the track";
  parameter Types.Modulus E_steel = 2.1e11 "Young's modulus of wheel and rail";
  parameter Types.Ratio nu_steel = 0.28 "Poisson's ratio of wheel and rail";
protected
  final parameter Real factor = Contact.creepFactor(r_wheel, r_rail, E_steel, nu_steel)
    "Slope of epsilon, see creepFactor";
  final parameter Types.Force Q = m_wheelset*g/2 "Load of a wheel";
  constant Types.Ratio creep_small = 1e-7 "Rounding of the total creep about zero: a force of about 1 N";
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{-70, 0}, {70, 0}}, color={0, 0, 127}),
        Rectangle(extent={{-60, 60}, {-40, -60}}, lineColor={0, 0, 127}),
        Rectangle(extent={{40, 60}, {60, -60}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Parameters of Mal et al. (2020), Table 1; loads and contact geometry are not in the paper: half of the mass on each
wheel, and the rail head of the other vehicles of this library.
</p>
<h4>Limitations</h4>
<p>
Straight track, constant conicity, no flange, no spin, equal loads. Kalker's c11 is used for the
lateral direction, too: the text of the paper has one coefficient of contact shear stiffness for both directions.
</p>
</html>"));
end PartialLateralWheelset;
