within RailBraking.Data;
record Disc "Brake disc and its cooling air"
  extends Icons.Record;
  parameter Types.Mass m(min=1e-3) = 110 "Mass of the disc";
  parameter Types.Mass m_surface(min=1e-3) = 12 "Mass of the friction rings near the surface";
  parameter Types.SpecificHeat c_p(min=1e-3) = 500 "Specific heat capacity of grey iron";
  parameter Types.HeatConductance G = 2500 "Heat conductance between surface and bulk";
  parameter Types.HeatConductance G_rest = 20 "Heat conductance to the air at rest";
  parameter Types.SpeedHeatConductance G_speed = 2.5 "Rise of the heat conductance to the air with speed";
  parameter Types.Ratio pad_share(min=0, max=1) = 0.07 "Share of the friction heat that stays in the pads";
  parameter Types.Temperature T_ambient = 293.15 "Temperature of the air";
  annotation (
    Documentation(info="<html>
<p>Parameters of <a href=\"modelica://RailBraking.Friction.Disc\">Disc</a>.</p>
</html>"));
end Disc;
