within RailBraking;
package Pneumatics "Actuation: from the command of the brake control to the pad force"
  constant Types.Pressure p_free = 1.01325e5 "Absolute pressure of free air";
  constant Types.Density rho_free = 1.2041 "Density of free air at 20 degrees Celsius";
  annotation (Documentation(info="<html>
<p>
Two actuations: <a href=\"modelica://RailBraking.Pneumatics.IdealCylinder\">IdealCylinder</a> follows
a pressure command with a small lag, as assumed in papers on control; <a
href=\"modelica://RailBraking.Pneumatics.ValveCylinder\">ValveCylinder</a> is
filled, held and vented by binary valves, as in service.
</p>
<p>
Upstream, a demand is transmitted by wire (<a
href=\"modelica://RailBraking.Pneumatics.ElectropneumaticCommand\">ElectropneumaticCommand</a>) or by the <a
href=\"modelica://RailBraking.Pneumatics.BrakePipe\">BrakePipe</a> and a <a
href=\"modelica://RailBraking.Pneumatics.Distributor\">Distributor</a> in each car, and air comes from a <a
href=\"modelica://RailBraking.Pneumatics.Reservoir\">Reservoir</a>. These are connected by <a
href=\"modelica://RailBraking.Interfaces.AirPort\">air ports</a>; air is isothermal, and counted as free air.
</p>
</html>"));
end Pneumatics;
