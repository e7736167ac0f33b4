within RailBraking.FMUs;
block Wagon "Wagon of two braked wheelsets whose cylinders follow pressure commands"
  extends Vehicles.PartialWagon;
  parameter Types.Time T_pressure = 0.05 "Time constant of the cylinder pressure" annotation(Dialog(group="Brake"));
  Interfaces.RealInput pressure_command[2](each final unit="Pa", each start=0)
    "Pressure that the cylinders of each wheelset shall have";
protected
  Pneumatics.IdealCylinder cylinder[2](each T=T_pressure, each p_max=p_max, each V=n_units*V_cylinder)
    "Cylinders of each wheelset";
equation
  for i in 1:2 loop
    cylinder[i].command = pressure_command[i];
    cylinder_pressure[i] = cylinder[i].pressure;
    pad_force[i] = Pneumatics.padForce(cylinder_pressure[i], A_piston, i_rigging, eta_rigging, F_spring);
  end for;
  annotation (Documentation(info="<html>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Vehicles.PartialWagon\">PartialWagon</a>.</p>
</html>"));
end Wagon;
