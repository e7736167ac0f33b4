within RailBraking.Plants;
block Wagon "Wagon of two braked wheelsets whose cylinders follow pressure commands"
  extends Icons.Vehicle;
  extends Vehicles.PartialWagon;
  parameter Types.Time T_pressure = 0.05 "Time constant of the cylinder pressure" annotation(Dialog(group="Brake"));
  Interfaces.RealInput pressure_command[2](each final unit="Pa", each start=0)
    "Commanded cylinder pressure of each wheelset"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
protected
  Pneumatics.IdealCylinder cylinder[2](each T=T_pressure, each p_max=p_max, each V=n_units*V_cylinder)
    "Cylinders of each wheelset"
    annotation(Placement(transformation(extent={{-60, -80}, {-20, -40}})));
  Pneumatics.Rigging rigging[2](
    each A_piston=A_piston, each i_rigging=i_rigging, each eta_rigging=eta_rigging, each F_spring=F_spring)
    "Rigging of each wheelset"
    annotation(Placement(transformation(extent={{20, -80}, {60, -40}})));
equation
  for i in 1:2 loop
    connect(pressure_command[i], cylinder[i].command)
      annotation(Line(points={{-110, 0}, {-90, 0}, {-90, -60}, {-62, -60}}, color={0, 0, 127}));
    connect(cylinder[i].pressure, rigging[i].pressure)
      annotation(Line(points={{-18, -50}, {0, -50}, {0, -60}, {18, -60}}, color={0, 0, 127}));
    connect(cylinder[i].pressure, cylinder_pressure[i])
      annotation(Line(points={{-18, -50}, {0, -50}, {0, -30}, {90, -30}, {90, -7}, {110, -7}}, color={0, 0, 127}));
    connect(rigging[i].pad_force, pad_force[i])
      annotation(Line(points={{62, -60}, {95, -60}, {95, -21}, {110, -21}}, color={0, 0, 127}));
  end for;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Vehicles.PartialWagon\">PartialWagon</a>.</p>
</html>"));
end Wagon;
