within RailBraking.FMUs;
block HeatedContactPoint "ContactPoint whose friction falls with the temperature of the contact"
  extends ContactPoint(
    mu=Contact.warmFriction(
      Contact.fallingFriction(slip*speed, mu0, A_falling, B_falling), load/2, slip*speed, R_wheel, R_rail,
      T_tread - T_rail, temperature_loss));
  parameter Types.TemperatureCoefficient temperature_loss(min=0) = 8.3e-4 "Share of friction lost a kelvin";
  parameter Types.HeatConductivity k_steel = 50 "Heat conductivity of wheel and rail";
  parameter Types.Density rho_steel = 7850 "Density of wheel and rail";
  parameter Types.SpecificHeat c_steel = 450 "Specific heat capacity of wheel and rail";
  parameter Types.Temperature T_rail = 293.15 "Temperature of the rail away from the contact";
  parameter Types.Temperature T_tread = 293.15 "Temperature of the treads away from the contact";
  parameter Types.Velocity v_small(min=1e-3) = 0.1 "Speed below which the motion of the contact is regularised";
protected
  final parameter Real a1 = Contact.semiAxis(r_wheel, r_rail, E_steel, nu_steel)
    "Semi-axis along the track over the cube root of the load";
  final parameter Types.Ratio ratio = (r_wheel/r_rail)^(2/3) "Semi-axis along the track over that across";
  Types.Length a = a1*(load/2)^(1/3) "Semi-axis along the track";
  Types.ThermalResistance R_wheel = Contact.flashResistance(
    a, a/ratio, sqrt(((1 - slip)*speed)^2 + v_small^2), k_steel, rho_steel, c_steel)
    "Temperature rise of the contact over the heat flow into the wheel";
  Types.ThermalResistance R_rail = Contact.flashResistance(
    a, a/ratio, sqrt(speed^2 + v_small^2), k_steel, rho_steel, c_steel)
    "Temperature rise of the contact over the heat flow into the rail";
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The adhesion of <a href=\"modelica://RailBraking.Contact.HeatedContact\">HeatedContact</a> at a temperature of the
treads, for programs that need the contact by itself.
</p>
<h4>Limitations</h4>
<p>Those of ContactPoint and HeatedContact. The temperature of the treads is given, not computed.</p>
</html>"));
end HeatedContactPoint;
