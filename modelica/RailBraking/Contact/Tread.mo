within RailBraking.Contact;
block Tread "Temperature of the rim of a wheel under its tread"
  extends Icons.Component;
  parameter Types.Mass m(min=1e-3) = 40 "Mass of the rim that takes part";
  parameter Types.SpecificHeat c_p = 450 "Specific heat capacity of steel";
  parameter Types.HeatConductance G_rest = 10 "Heat conductance to the air at rest";
  parameter Types.SpeedHeatConductance G_speed = 2 "Rise of the heat conductance to the air with speed";
  parameter Types.Temperature T_ambient = 293.15 "Temperature of the air";
  parameter Types.Temperature T_start = 293.15 "Temperature at the start";
  Interfaces.RealInput heat_flow(final unit="W") "Heat from the contact and from tread brakes, less that to the rail"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput speed(final unit="m/s") "Speed of the vehicle"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));
  Interfaces.RealOutput temperature(final unit="K") "Temperature of the rim"
    annotation(Placement(transformation(extent={{100, 40}, {120, 60}})));
  Interfaces.RealOutput cooling(final unit="W") "Heat flow to the air"
    annotation(Placement(transformation(extent={{100, -60}, {120, -40}})));
protected
  Types.Temperature T(start=T_start, fixed=true) "Temperature of the rim";
equation
  cooling = (G_rest + G_speed*speed)*(T - T_ambient);
  m*c_p*der(T) = heat_flow - cooling;
  temperature = T;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The temperature that a contact meets before it heats: m c_p dT/dt = heat_flow - (G_rest + G_speed speed)
(T - T_ambient). Chill by the rail is in <code>heat_flow</code>, see
<a href=\"modelica://RailBraking.Contact.HeatedContact\">HeatedContact</a>.
</p>
<h4>Limitations</h4>
<p>
One temperature for the whole circumference: a locked wheel heats one spot instead. The mass is an estimate: heat
penetrates &radic;(k t/(rho c_p)), 20 mm in half a minute, under a running band of 0.1 m on a circumference of 2.4 m.
In longer braking the mass is that of the whole rim, some five times as much. The conductances are estimates; radiation
is left out.
</p>
</html>"));
end Tread;
