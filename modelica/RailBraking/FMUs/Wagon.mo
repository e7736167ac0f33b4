within RailBraking.FMUs;
block Wagon "Wagon of two braked wheelsets whose cylinders follow pressure commands"
  extends Vehicles.PartialWagon;
  parameter Types.Time T_pressure = 0.05 "Time constant of the cylinder pressure" annotation(Dialog(group="Brake"));
  Interfaces.RealInput pressure_command[2](each final unit="Pa", each start=0)
    "Pressure that the cylinders of each wheelset shall have"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
protected
  Pneumatics.IdealCylinder cylinder[2](each T=T_pressure, each p_max=p_max, each V=n_units*V_cylinder)
    "Cylinders of each wheelset"
    annotation(Placement(transformation(extent={{-20, -20}, {20, 20}})));
equation
  for i in 1:2 loop
    cylinder[i].command = pressure_command[i];
    cylinder_pressure[i] = cylinder[i].pressure;
    pad_force[i] = Pneumatics.padForce(cylinder_pressure[i], A_piston, i_rigging, eta_rigging, F_spring);
  end for;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Vehicles.PartialWagon\">PartialWagon</a>.</p>
</html>"));
end Wagon;
