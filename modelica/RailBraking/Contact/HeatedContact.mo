within RailBraking.Contact;
block HeatedContact "The two contacts of one wheelset, whose friction falls with their temperature"
  extends Icons.Contact;
  extends Interfaces.PartialContact;
  parameter Types.TemperatureCoefficient temperature_loss(min=0) = 8.3e-4 "Share of friction lost a kelvin";
  parameter Types.Ratio removal_share(min=0, max=1) = 0 "Share of the slip power that removes film and steel";
  parameter Types.HeatConductivity k_steel = 50 "Heat conductivity of wheel and rail";
  parameter Types.Density rho_steel = 7850 "Density of wheel and rail";
  parameter Types.SpecificHeat c_steel = 450 "Specific heat capacity of wheel and rail";
  parameter Types.Temperature T_rail = 293.15 "Temperature of the rail away from the contact";
  input Types.Ratio mu_cold = fallingFriction(v - r*w, mu0, curve.A, curve.B) "Friction at the temperature of the rail";
  input Types.Power pad_power = 0 "Heat of tread brakes into both wheels";
  final parameter Real factor = creepFactor(r_effective, r_rail, E, nu) "Slope of epsilon, see creepFactor";
  Tread tread(c_p=c_steel, T_ambient=T_rail, T_start=T_rail) "Rim of each wheel"
    annotation(Placement(transformation(extent={{-20, -20}, {20, 20}})));
  Types.Temperature T_contact "Mean temperature of each contact";
  Types.Power heat_wheel "Heat from both contacts into the wheels, less what the rails take from hot treads";
  Types.Power heat_rail "Heat from both contacts into the rails";
  Types.Power removal_power "Power that removes film and steel in both contacts";
protected
  final parameter Types.Force F_small = 100 "Rounding of the load about zero";
  final parameter Types.Length r_effective = r/(1 + r*curvature_rail) "Radius of the wheel on a straight rail";
  final parameter Real a1 = semiAxis(r_effective, r_rail, E, nu) "Semi-axis over the cube root of the load";
  final parameter Types.Ratio ratio = (r_effective/r_rail)^(2/3) "Semi-axis along the track over that across";
  Types.Force Q "Load of each wheel, rounded to stay positive if the wheelset is unloaded";
  Types.Length a "Semi-axis along the track";
  Types.ThermalResistance R_wheel "Temperature rise of the contact over the heat flow into the wheel";
  Types.ThermalResistance R_rail "Temperature rise of the contact over the heat flow into the rail";
  Types.Ratio mu "Friction at the temperature of the contact";
  Types.Power heat "Heat of each contact";
equation
  slip = (v - r*w)/sqrt(v^2 + v_small^2);
  Q = (load + sqrt(load^2 + F_small^2))/4;
  a = a1*Q^(1/3);
  R_wheel = flashResistance(a, a/ratio, sqrt((r*w)^2 + v_small^2), k_steel, rho_steel, c_steel);
  R_rail = flashResistance(a, a/ratio, sqrt(v^2 + v_small^2), k_steel, rho_steel, c_steel);
  mu = warmFriction(
    mu_cold, (1 - removal_share)*Q, v - r*w, R_wheel, R_rail, tread.temperature - T_rail, temperature_loss);
  alpha = polach(slip, 0, Q, mu, factor, curve.k_A, curve.k_S, 1, 0);
  F = 2*alpha*Q;
  heat_flow = F*(v - r*w);
  removal_power = removal_share*heat_flow;
  heat = (heat_flow - removal_power)/2;
  heat_wheel = 2*(R_rail*heat + T_rail - tread.temperature)/(R_wheel + R_rail);
  heat_rail = 2*heat - heat_wheel;
  T_contact = T_rail + R_rail*heat_rail/2;
  tread.heat_flow = (heat_wheel + pad_power)/2;
  tread.speed = v;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Ellipse(extent={{-50, 70}, {50, -30}}, lineColor={0, 0, 127}),
        Line(points={{-80, -30}, {80, -30}}, color={0, 0, 127}),
        Line(points={{0, -30}, {0, 10}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
<a href=\"modelica://RailBraking.Contact.WheelsetContact\">WheelsetContact</a> with
<a href=\"modelica://RailBraking.Contact.warmFriction\">warmFriction</a> in place of the cold one. With
temperature_loss = 0 both have the same force. The slip power becomes heat of the wheels, heat of the rails and removal,
heat_flow = heat_wheel + heat_rail + removal_power.
</p>
<p>
The default of temperature_loss, friction of zero at a rise of 1200 K, follows the dry curve of Polach (2005), A = 0.4
and B = 0.6 s/m, within 6 % (root mean square) up to a slip speed of 5 m/s at 68.5 kN and 40 km/h. Where friction of
steel on steel falls with temperature, A = 1 or B = 0; other values of A and B belong to the film between them.
</p>
<h4>Limitations</h4>
<p>
Those of <a href=\"modelica://RailBraking.Contact.WheelsetContact\">WheelsetContact</a>,
<a href=\"modelica://RailBraking.Contact.flashResistance\">flashResistance</a>,
<a href=\"modelica://RailBraking.Contact.warmFriction\">warmFriction</a> and
<a href=\"modelica://RailBraking.Contact.Tread\">Tread</a>. Every wheel meets a cold rail: what those ahead have left in
it, some kelvin after metres, is left out. Water that boils in the contact is not modelled.
</p>
</html>"));
end HeatedContact;
