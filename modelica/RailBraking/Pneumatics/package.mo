within RailBraking;
package Pneumatics "From what the brake control asks to the force on the pads"
  annotation (Documentation(info="<html>
<p>
Two actuations: <a href=\"modelica://RailBraking.Pneumatics.IdealCylinder\">IdealCylinder</a> follows a pressure command
with a small lag, as control papers assume; <a
href=\"modelica://RailBraking.Pneumatics.ValveCylinder\">ValveCylinder</a> is
filled, held and vented by binary valves, as in service.
</p>
</html>"));
end Pneumatics;
