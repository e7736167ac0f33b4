within RailBraking;
package Interfaces "Signals, physical connectors, and partial models for each kind of component"
  annotation (Documentation(info="<html>
<p>
Car bodies, bogies, couplers, axles and air are joined by physical connectors, whose flows add up to zero:
<a href=\"modelica://RailBraking.Interfaces.TranslationalFlange\">TranslationalFlange</a>,
<a href=\"modelica://RailBraking.Interfaces.RotationalFlange\">RotationalFlange</a> and
<a href=\"modelica://RailBraking.Interfaces.AirPort\">AirPort</a>. Everything else is a signal; those
of a group, of a wheelset or sums over them are records, <a
href=\"modelica://RailBraking.Interfaces.GroupOutput\">GroupOutput</a>, <a
href=\"modelica://RailBraking.Interfaces.WheelsetOutput\">WheelsetOutput</a> and <a
href=\"modelica://RailBraking.Interfaces.TotalsOutput\">TotalsOutput</a>.
</p>
</html>"));
end Interfaces;
