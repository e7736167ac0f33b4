within RailBraking.FMUs;
block TrainPrediction "Two-part train as an estimator believes it to be"
  extends Vehicles.PartialPrediction;
  parameter Types.Mass m_unsprung[6](each min=0) = {1500, 1500, 1300, 1300, 1500, 1500} "Mass of each wheelset itself";
  parameter Types.Mass m_frame[3](each min=1e-3) = {3500, 2800, 3500} "Mass of each bogie frame";
  parameter Types.Inertia I_frame[3](each min=1e-3) = {2200, 2300, 2200} "Pitch inertia of each bogie frame";
  parameter Types.Length wheelbase[3](each min=1e-3) = {1.9, 2.65, 1.9} "Distance of the wheelsets of each bogie";
  parameter Types.Length h_frame = 0.55 "Height of the frames' centres of gravity over the rail";
  parameter Types.Length h_rod = 0.40 "Height of the traction rods over the rail";
  parameter Types.Stiffness k_primary = 2.4e6 "Stiffness of the primary suspension over one wheelset";
  parameter Types.Damping c_primary = 2.4e4 "Damping of the primary suspension over one wheelset";
  Interfaces.RealOutput speed(final unit="m/s") = v "Speed of the train"
    annotation(Placement(transformation(extent={{100, 65}, {120, 85}})));
  Interfaces.RealOutput wheelset_speed[4](each final unit="rad/s") = w "Angular velocity of each group"
    annotation(Placement(transformation(extent={{100, 15}, {120, 35}})));
  Interfaces.RealOutput deflection[6](each final unit="m") = dz
    "Deflection of the primary suspension, change from static, compression positive"
    annotation(Placement(transformation(extent={{100, -35}, {120, -15}})));
  Interfaces.RealOutput acceleration(final unit="m/s2") = der(v) "Acceleration of the train"
    annotation(Placement(transformation(extent={{100, -85}, {120, -65}})));
  Types.Length dz[6](each start=0, each fixed=true, each stateSelect=StateSelect.always)
    "Deflection of the primary suspension over each wheelset, change from static, compression positive";
  Types.Velocity ddz[6](each start=0, each fixed=true, each stateSelect=StateSelect.always) "Rate of the deflection";
protected
  Types.Force spring[6] "Spring and damper force over each wheelset, change from static";
  Types.Force F_bogie[3] "Braking force of the track on each bogie";
  Types.Torque tipping[3] "Torque that tips each frame nose-down, springs excluded";
  Types.Torque torque_bogie[3] "Brake torque of each bogie";
equation
  spring = k_primary*dz + c_primary*ddz;
  load = {
    g*(m_wheelset[1] + m_wheelset[2]) + spring[1] + spring[2],
    g*m_wheelset[3] + spring[3],
    g*m_wheelset[4] + spring[4],
    g*(m_wheelset[5] + m_wheelset[6]) + spring[5] + spring[6]};
  F_bogie = {F[1], F[2] + F[3], F[4]};
  torque_bogie = {torque[1], torque[2] + torque[3], torque[4]};
  der(dz) = ddz;
  for i in 1:3 loop
    tipping[i] = Components.frameTorque(
      F_bogie[i], torque_bogie[i], der(v),
      m_unsprung[2*i - 1] + m_unsprung[2*i], m_frame[i], h_frame, h_rod, r_wheel);
    der(ddz[2*i - 1]) = Components.deflectionAcceleration(
      tipping[i], spring[2*i - 1], spring[2*i], m_frame[i], I_frame[i], wheelbase[i]/2);
    der(ddz[2*i]) = Components.deflectionAcceleration(
      tipping[i], spring[2*i], spring[2*i - 1], m_frame[i], I_frame[i], -wheelbase[i]/2);
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
<p>
Twenty-five states: v, w, mu_b, alpha, dz, ddz, in this order; equation (7) of Schwarz, Posielek and Goetjes. Free of
events. The adhesion of a group is that of both its wheelsets.
</p>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Vehicles.PartialPrediction\">PartialPrediction</a>.</p>
</html>"));
end TrainPrediction;
