within RailBraking.Components;
model BogieFrame "Bogie frame on its primary suspension: bounce and pitch"
  parameter Types.Mass m_wheelset[2](start={14000, 14000})
    "Mass that each wheelset carries on the rail, its own included";
  parameter Types.Mass m_unsprung[2](start={1500, 1500}) "Mass of each wheelset itself";
  parameter Types.Mass m_frame(start=3500) "Mass of the frame";
  parameter Types.Inertia I_frame(start=2200) "Pitch inertia of the frame";
  parameter Types.Length h_frame(start=0.55) "Height of the frame's centre of gravity over the rail";
  parameter Types.Length h_rod(start=0.40) "Height of the traction rod over the rail";
  parameter Types.Length wheelbase(start=1.9) "Distance of the wheelsets";
  parameter Types.Length r_wheel(start=0.38) "Height of the axles over the rail";
  parameter Types.Stiffness k(start=2.4e6) "Stiffness of the primary suspension over one wheelset";
  parameter Types.Damping c(start=2.4e4) "Damping of the primary suspension over one wheelset";
  Interfaces.RealInput a(final unit="m/s2") "Acceleration along the track"
    annotation(Placement(transformation(extent={{-120, 57}, {-100, 77}})));
  Interfaces.RealInput F(final unit="N") "Braking force of the track on both wheelsets together"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealInput torque(final unit="N.m") "Brake torque on both wheelsets together"
    annotation(Placement(transformation(extent={{-120, -77}, {-100, -57}})));
  Interfaces.RealOutput load[2](each final unit="N") "Load of each wheelset on the rail"
    annotation(Placement(transformation(extent={{100, 65}, {120, 85}})));
  Interfaces.RealOutput work_power(final unit="W") "Power that the longitudinal forces put into the pitching frame"
    annotation(Placement(transformation(extent={{100, 15}, {120, 35}})));
  Interfaces.RealOutput damper_power(final unit="W") "Heat made in the dampers"
    annotation(Placement(transformation(extent={{100, -35}, {120, -15}})));
  Interfaces.RealOutput stored_energy(final unit="J") "Energy of the moving frame and of the springs"
    annotation(Placement(transformation(extent={{100, -85}, {120, -65}})));
  Types.Length dz[2](each start=0, each fixed=true)
    "Deflection over each wheelset, change from static, compression positive";
  Types.Velocity ddz[2](each start=0, each fixed=true) "Rate of the deflection";
protected
  Types.Force spring[2] "Spring and damper force over each wheelset, change from static";
  Types.Torque tipping "Torque that tips the frame nose-down, springs excluded";
equation
  der(dz) = ddz;
  spring = k*dz + c*ddz;
  tipping = frameTorque(F, torque, a, sum(m_unsprung), m_frame, h_frame, h_rod, r_wheel);
  der(ddz[1]) = deflectionAcceleration(tipping, spring[1], spring[2], m_frame, I_frame, wheelbase/2);
  der(ddz[2]) = deflectionAcceleration(tipping, spring[2], spring[1], m_frame, I_frame, -wheelbase/2);
  load = g*m_wheelset + spring;
  work_power = tipping*(ddz[1] - ddz[2])/wheelbase;
  damper_power = c*(ddz[1]^2 + ddz[2]^2);
  stored_energy = m_frame*((ddz[1] + ddz[2])/2)^2/2 + I_frame*((ddz[1] - ddz[2])/wheelbase)^2/2
    + k*(dz[1]^2 + dz[2]^2)/2;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Line(points={{-80, 10}, {80, 10}}, color={0, 0, 127}),
        Ellipse(extent={{-90, 0}, {-30, -60}}, lineColor={0, 0, 127}),
        Ellipse(extent={{30, 0}, {90, -60}}, lineColor={0, 0, 127}),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
In braking the front wheelset gains the load that the rear one loses; at rest on level track that is
&plusmn;&Sigma;F h_rod/wheelbase for massless parts (see <a
href=\"modelica://RailBraking.Validation.LoadTransfer\">LoadTransfer</a> for the exact value).
</p>
<h4>Limitations</h4>
<p>
Those of <code>deflectionAcceleration</code>. All masses move along the track at the speed of the train: the power that
pitching draws from the longitudinal motion, <code>work_power</code>, is not taken back from it. Its integral is exactly
the heat of the dampers plus <code>stored_energy</code>: of twenty megajoules, some ten joules in a smooth stop and
15 kJ where slip control throws the brakes on and off throughout.
</p>
</html>"));
end BogieFrame;
