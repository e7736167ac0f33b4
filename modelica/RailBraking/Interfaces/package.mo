within RailBraking;
package Interfaces "Signals, mechanical connections, and what each kind of part has in common"
  annotation (Documentation(info="<html>
<p>
Car bodies, bogies, couplers and axles are joined by physical connectors, whose flows add up to zero:
<a href=\"modelica://RailBraking.Interfaces.TranslationalFlange\">TranslationalFlange</a> and
<a href=\"modelica://RailBraking.Interfaces.RotationalFlange\">RotationalFlange</a>. Everything else is a signal.
</p>
</html>"));
end Interfaces;
