within RailBraking.FMUs;
block TwoPartTrain "Two-part train whose cylinders follow pressure commands"
  extends Vehicles.PartialTwoPartTrain;
  parameter Types.Time T_pressure(min=1e-4) = 0.02 "Time constant of the cylinder pressure"
    annotation(Dialog(group="Brake"));
  Interfaces.RealInput pressure_command[4](each final unit="Pa", each start=0)
    "Pressure that the cylinders of each group shall have"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
protected
  Pneumatics.IdealCylinder cylinder[4](
    each T=T_pressure, p_max=p_max, p_start=p_start, V=V_group, each p_free=p_free) "Cylinders of each group"
    annotation(Placement(transformation(extent={{-20, -20}, {20, 20}})));
equation
  for i in 1:4 loop
    cylinder[i].command = pressure_command[i];
    cylinder_pressure[i] = cylinder[i].pressure;
    pad_force[i] = Pneumatics.padForce(cylinder_pressure[i], A_piston, i_rigging, eta_rigging, F_spring);
  end for;
  air_flow = sum(cylinder.air_flow);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The actuation that control papers assume. For valves as in service see
<a href=\"modelica://RailBraking.FMUs.TwoPartTrainPneumatic\">TwoPartTrainPneumatic</a>.
</p>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Vehicles.PartialTwoPartTrain\">PartialTwoPartTrain</a>.</p>
</html>"));
end TwoPartTrain;
