within RailBraking.Vehicles;
partial block PartialUniformTrain "Train with bogies, riggings and pads of one kind"
  extends Icons.Vehicle;
  extends PartialTrain;
  parameter Types.Length h_frame = 0.55 "Height of the frames' centres of gravity over the rail"
    annotation(Dialog(group="Geometry"));
  parameter Types.Length h_rod = 0.40 "Height of the traction rods over the rail" annotation(Dialog(group="Geometry"));
  parameter Types.Stiffness k_primary = 2.4e6 "Stiffness of the primary suspension over one wheelset"
    annotation(Dialog(group="Suspension"));
  parameter Types.Damping c_primary = 2.4e4 "Damping of the primary suspension over one wheelset"
    annotation(Dialog(group="Suspension"));
  parameter Types.Area A_piston(min=1e-6) = 0.0324 "Area of a piston" annotation(Dialog(group="Brake"));
  parameter Types.Ratio i_rigging(min=1e-6) = 6 "Force of both pads over force of the piston"
    annotation(Dialog(group="Brake"));
  parameter Types.Ratio eta_rigging(min=0, max=1) = 0.95 "Efficiency of the rigging" annotation(Dialog(group="Brake"));
  parameter Types.Force F_spring = 1200 "Force of return spring and slack adjuster" annotation(Dialog(group="Brake"));
  parameter Types.Ratio speed_effect = 0.12 "Rise of pad friction from nominal speed to standstill, relative"
    annotation(Dialog(group="Pads"));
  parameter Types.Velocity pad_speed_nominal(min=1e-3) = 13 "Sliding speed at which pad friction is nominal"
    annotation(Dialog(group="Pads"));
  parameter Types.Ratio temperature_effect = 0.10 "Rise of pad friction over the temperature range, relative"
    annotation(Dialog(group="Pads"));
  parameter Types.Temperature temperature_nominal = 333.15 "Disc temperature at which pad friction is nominal"
    annotation(Dialog(group="Pads"));
  parameter Types.TemperatureDifference temperature_range(min=1e-3) = 150
    "Temperature rise at which the effect saturates"
    annotation(Dialog(group="Pads"));
  parameter Types.Ratio force_effect = 0.08 "Loss of pad friction at twice the nominal pad force, relative"
    annotation(Dialog(group="Pads"));
  parameter Types.Force pad_force_nominal(min=1e-3) = 56e3 "Pad force at which pad friction is nominal"
    annotation(Dialog(group="Pads"));
  parameter Types.Energy E_settle(min=1e-3) = 2e5 "Friction energy of one unit within which pad friction settles"
    annotation(Dialog(group="Pads"));
  parameter Types.Time T_settle(min=1e-3) = 3 "Time within which pad friction settles at low power"
    annotation(Dialog(group="Pads"));
  parameter Types.Force F_release(min=1e-3) = 1e3 "Pad force below which pads count as released"
    annotation(Dialog(group="Pads"));
protected
  final parameter Data.Pad pads = Data.Pad(
    speed_effect=speed_effect, pad_speed_nominal=pad_speed_nominal, temperature_effect=temperature_effect,
    temperature_nominal=temperature_nominal, temperature_range=temperature_range, force_effect=force_effect,
    pad_force_nominal=pad_force_nominal, E_settle=E_settle, T_settle=T_settle, F_release=F_release) "Pads";
  final parameter Data.Suspension suspension = Data.Suspension(
    h_frame=h_frame, h_rod=h_rod, k=k_primary, c=c_primary) "Frames and primary suspension";
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-90, 40}, {-2, -40}}, lineColor={0, 0, 127}),
        Rectangle(extent={{2, 40}, {90, -40}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Parameters that are the same for all cars of a train, such as <a
href=\"modelica://RailBraking.Vehicles.PartialConsist\">PartialConsist</a>; a train of a locomotive
and coaches has them for each kind of bogie.
</p>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Vehicles.PartialTrain\">PartialTrain</a>.</p>
</html>"));
end PartialUniformTrain;
