within RailBraking.Plants;
block Consist "Train of equal cars whose cylinders follow pressure commands"
  extends Icons.Vehicle;
  extends Vehicles.PartialConsist(cars=4);
  parameter Types.Time T_pressure(min=1e-4) = 0.02 "Time constant of the cylinder pressure"
    annotation(Dialog(group="Brake"));
  Interfaces.RealInput pressure_command[groups](each final unit="Pa", each start=0)
    "Commanded cylinder pressure of each group"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
protected
  Pneumatics.IdealCylinder cylinder[groups](
    each T=T_pressure, p_max=p_max, p_start=p_start, V=V_group, each p_free=p_free) "Cylinders of each group"
    annotation(Placement(transformation(extent={{-60, -80}, {-20, -40}})));
  Pneumatics.Rigging rigging[groups](
    each A_piston=A_piston, each i_rigging=i_rigging, each eta_rigging=eta_rigging, each F_spring=F_spring)
    "Rigging of each group"
    annotation(Placement(transformation(extent={{20, -80}, {60, -40}})));
equation
  for i in 1:groups loop
    connect(pressure_command[i], cylinder[i].command)
      annotation(Line(points={{-110, 0}, {-90, 0}, {-90, -60}, {-62, -60}}, color={0, 0, 127}));
    connect(cylinder[i].pressure, rigging[i].pressure)
      annotation(Line(points={{-18, -50}, {0, -50}, {0, -60}, {18, -60}}, color={0, 0, 127}));
    connect(cylinder[i].pressure, cylinder_pressure[i])
      annotation(Line(points={{-18, -50}, {0, -50}, {0, -30}, {90, -30}, {90, 26}, {110, 26}}, color={0, 0, 127}));
    connect(rigging[i].pad_force, pad_force[i])
      annotation(Line(points={{62, -60}, {95, -60}, {95, 18}, {110, 18}}, color={0, 0, 127}));
  end for;
  air_flow = sum(cylinder.air_flow);
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>Actuation as assumed in papers on control; four cars unless it is extended with another number.</p>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Vehicles.PartialConsist\">PartialConsist</a>.</p>
</html>"));
end Consist;
