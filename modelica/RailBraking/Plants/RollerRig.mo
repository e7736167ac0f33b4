within RailBraking.Plants;
block RollerRig "One braked wheelset on a roller that represents the rail and the wagon"
  extends Icons.Vehicle;
  extends Vehicles.PartialRollerRig;
  parameter Types.Time T_fill = 0.4 "Time constant of filling" annotation(Dialog(group="Brake"));
  parameter Types.Time T_vent = 0.2 "Time constant of venting" annotation(Dialog(group="Brake"));
  parameter Types.Time dead_fill(min=0, max=0.126) = 0.05 "Dead time of the fill valve"
    annotation(Dialog(group="Brake"));
  parameter Types.Time dead_vent(min=0, max=0.126) = 0.04 "Dead time of the vent valve"
    annotation(Dialog(group="Brake"));
  Interfaces.RealInput valve_command(final unit="1", start=0) "Valves: -1 vent, 0 hold, 1 fill"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
protected
  Pneumatics.ValveCylinder cylinder(
    p_max=p_max, V=n_units*V_cylinder, T_fill=T_fill, T_vent=T_vent, dead_fill=dead_fill,
    dead_vent=dead_vent) "Cylinders"
    annotation(Placement(transformation(extent={{-60, -80}, {-20, -40}})));
  Pneumatics.Rigging rigging(
    A_piston=A_piston, i_rigging=i_rigging, eta_rigging=eta_rigging, F_spring=F_spring) "Rigging"
    annotation(Placement(transformation(extent={{20, -80}, {60, -40}})));
equation
  connect(valve_command, cylinder.command)
    annotation(Line(points={{-110, 0}, {-90, 0}, {-90, -60}, {-62, -60}}, color={0, 0, 127}));
  connect(cylinder.pressure, rigging.pressure)
    annotation(Line(points={{-18, -50}, {0, -50}, {0, -60}, {18, -60}}, color={0, 0, 127}));
  connect(cylinder.pressure, cylinder_pressure)
    annotation(Line(points={{-18, -50}, {0, -50}, {0, -30}, {90, -30}, {90, -6}, {110, -6}}, color={0, 0, 127}));
  connect(rigging.pad_force, pad_force)
    annotation(Line(points={{62, -60}, {95, -60}, {95, -19}, {110, -19}}, color={0, 0, 127}));
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Vehicles.PartialRollerRig\">PartialRollerRig</a>.</p>
</html>"));
end RollerRig;
