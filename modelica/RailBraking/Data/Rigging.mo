within RailBraking.Data;
record Rigging "Piston, levers and return spring of one brake unit"
  parameter Types.Area A_piston(min=1e-6) = 0.0324 "Area of the piston";
  parameter Types.Ratio i_rigging(min=1e-6) = 6 "Force of both pads over force of the piston";
  parameter Types.Ratio eta_rigging(min=0, max=1) = 0.95 "Efficiency of the rigging";
  parameter Types.Force F_spring = 1200 "Force of return spring and slack adjuster";
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Documentation(info="<html>
<p>Parameters of <a href=\"modelica://RailBraking.Pneumatics.padForce\">padForce</a>.</p>
</html>"));
end Rigging;
