within RailBraking.FMUs;
block Consist "Train of equal cars whose cylinders follow pressure commands"
  extends Vehicles.PartialConsist(cars=4);
  parameter Types.Time T_pressure(min=1e-4) = 0.02 "Time constant of the cylinder pressure"
    annotation(Dialog(group="Brake"));
  Interfaces.RealInput pressure_command[groups](each final unit="Pa", each start=0)
    "Pressure that the cylinders of each group shall have"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
protected
  Pneumatics.IdealCylinder cylinder[groups](
    each T=T_pressure, p_max=p_max, p_start=p_start, V=V_group, each p_free=p_free) "Cylinders of each group"
    annotation(Placement(transformation(extent={{-20, -80}, {20, -40}})));
equation
  for i in 1:groups loop
    cylinder[i].command = pressure_command[i];
    cylinder_pressure[i] = cylinder[i].pressure;
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
<p>The actuation that control papers assume, four cars unless it is extended with another number.</p>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Vehicles.PartialConsist\">PartialConsist</a>.</p>
</html>"));
end Consist;
