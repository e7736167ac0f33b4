within SimpleTrain;
model Axle "A wheelset on the rail with its brake units and their cylinders"
  parameter Real J(final unit="kg.m2", min=1, start=120) "Inertia";
  parameter Real r_wheel(final unit="m", min=0.1, start=0.46) "Rolling radius";
  parameter Real n_units(final unit="1", min=1, start=2) "Number of brake units";
  parameter Real r_friction(final unit="m", min=1e-3, start=0.24) "Radius at which the pads rub";
  parameter Real p_max(final unit="Pa", min=1, start=3.2e5) "Largest cylinder pressure";
  parameter Real A_piston(final unit="m2", min=1e-6, start=0.0324) "Area of a piston";
  parameter Real i_rigging(final unit="1", min=1e-3, start=5) "Force of both pads over force of the piston";
  parameter Real eta_rigging(final unit="1", min=1e-3, max=1, start=0.95) "Efficiency of the rigging";
  parameter Real F_spring(final unit="N", min=0, start=1200) "Force of the return spring";
  parameter Real T_pressure(final unit="s", min=1e-3, start=0.05) "Time constant of the cylinder pressure";
  parameter Real k_A(final unit="1", start=0.3) "Polach: reduction of the creep stiffness in the area of adhesion";
  parameter Real k_S(final unit="1", start=0.1) "Polach: reduction of the creep stiffness in the area of slip";
  parameter Real A_falling(final unit="1", start=0.4) "Polach: friction at infinite slip speed over maximum friction";
  parameter Real B_falling(final unit="s/m", start=0.2) "Polach: rate at which friction falls with slip speed";
  parameter Real start_speed(final unit="m/s", min=0, start=30) "Speed at the start";
  input Real speed(final unit="m/s") "Speed of the train";
  input Real load(final unit="N") "Load on the rail";
  input Real mu0(final unit="1") "Maximum friction of the rail";
  input Real pressure_command(final unit="Pa") "Pressure that the cylinders shall have";
  input Boolean standstill "= true, if the train stands";
  output Real w(final unit="rad/s") = wheels.w "Angular velocity";
  output Real slip(final unit="1") = wheels.contact[1].slip "Slip";
  output Real force(final unit="N") = wheels.F[1] "Braking force of the rail";
  output Real torque(final unit="N.m") = wheels.torque "Torque of the brake";
  output Real capacity(final unit="N") = wheels.capacity "Force with which it can hold the train at rest";
  output Boolean locked = wheels.locked "= true, if the wheelset does not turn";
  output Real pressure(final unit="Pa") = cylinder.pressure "Pressure in the cylinders";
  output Real pad_force(final unit="N") "Normal force of both pads of one unit";
  output Real pad_friction(final unit="1") = brake.pad.mu "Friction of the pads";
protected
  RailBraking.Components.Wheelsets wheels(
    final n=1, J=J, r=r_wheel, curve={RailBraking.Data.CreepCurve(k_A=k_A, k_S=k_S, A=A_falling, B=B_falling)},
    w_start=start_speed/r_wheel) "Wheelset on the rail";
  RailBraking.Components.GroupBrake brake(n_units=n_units, r_friction=r_friction) "Brake units";
  RailBraking.Pneumatics.IdealCylinder cylinder(T=T_pressure, p_max=p_max, V=6e-3) "Cylinders";
equation
  cylinder.command = pressure_command;
  pad_force = RailBraking.Pneumatics.padForce(pressure, A_piston, i_rigging, eta_rigging, F_spring);
  brake.pad_force = pad_force;
  brake.w = w;
  brake.speed = speed;
  wheels.v = speed;
  wheels.load = {load};
  wheels.mu0 = {mu0};
  wheels.brake_torque = brake.torque;
  wheels.standstill = standstill;
end Axle;
