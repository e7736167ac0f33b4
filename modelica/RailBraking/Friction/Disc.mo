within RailBraking.Friction;
block Disc "Brake disc of two thermal nodes, cooled by the airstream"
  extends Icons.Component;
  parameter Types.Mass m = 110 "Mass of the disc";
  parameter Types.Mass m_surface = 12 "Mass of the friction rings near the surface";
  parameter Types.SpecificHeat c_p = 500 "Specific heat capacity of grey iron";
  parameter Types.HeatConductance G = 2500 "Heat conductance between surface and bulk";
  parameter Types.HeatConductance G_rest = 20 "Heat conductance to the air at rest";
  parameter Types.SpeedHeatConductance G_speed = 2.5 "Rise of the heat conductance to the air with speed";
  parameter Types.Ratio pad_share = 0.07 "Share of the friction heat that stays in the pads";
  parameter Types.Temperature T_ambient = 293.15 "Temperature of the air";
  parameter Types.Temperature T_start = 313.15 "Temperature of the disc at the start";
  Interfaces.RealInput heat_flow(final unit="W") "Friction heat of one brake unit"
    annotation(Placement(transformation(extent={{-120, 40}, {-100, 60}})));
  Interfaces.RealInput speed(final unit="m/s") "Speed of the vehicle"
    annotation(Placement(transformation(extent={{-120, -60}, {-100, -40}})));
  Interfaces.RealOutput temperature(final unit="K") "Temperature of the bulk"
    annotation(Placement(transformation(extent={{100, 40}, {120, 60}})));
  Interfaces.RealOutput temperature_surface(final unit="K") "Temperature of the surface"
    annotation(Placement(transformation(extent={{100, -60}, {120, -40}})));
protected
  Types.Temperature T_bulk(start=T_start, fixed=true) "Temperature of the bulk";
  Types.Temperature T_surface(start=T_start, fixed=true) "Temperature of the surface";
  Types.Power conducted "Heat flow from the surface to the bulk";
equation
  conducted = G*(T_surface - T_bulk);
  m_surface*c_p*der(T_surface) = (1 - pad_share)*heat_flow - conducted;
  (m - m_surface)*c_p*der(T_bulk) = conducted - (G_rest + G_speed*speed)*(T_bulk - T_ambient);
  temperature = T_bulk;
  temperature_surface = T_surface;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
A ventilated disc of grey iron: the surface is hotter than the bulk by (1 - pad_share) heat_flow/G, about 100 K in an
emergency braking from 80 km/h.
</p>
<h4>Limitations</h4>
<p>
Radiation, the heat stored in the pads and the heat flow into the hub are neglected; hot spots are far hotter than the
surface node. <code>G</code> follows from 10 mm of grey iron under 0.5 m<sup>2</sup> of friction ring and is an
estimate.
</p>
</html>"));
end Disc;
