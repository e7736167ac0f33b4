within RailBraking.Vehicles;
partial block PartialBogiePrediction "Bogie of two wheelsets as an estimator believes it to be"
  extends PartialGroupPrediction;
  parameter Types.Mass m_wheelset[2](each min=1e-3) = {15e3, 15e3}
    "Mass that each wheelset carries on the rail, its own included";
  parameter Types.Mass m_unsprung[2](each min=0) = {1500, 1500} "Mass of each wheelset itself";
  parameter Types.Mass m_frame(min=1e-3) = 3500 "Mass of the frame";
  parameter Types.Inertia I_frame(min=1e-3) = 2200 "Pitch inertia of the frame";
  parameter Types.Length wheelbase(min=1e-3) = 1.9 "Distance of the wheelsets";
  parameter Types.Length h_frame = 0.55 "Height of the frame's centre of gravity over the rail";
  parameter Types.Length h_rod = 0.40 "Height of the traction rod over the rail";
  parameter Types.Stiffness k_primary = 2.4e6 "Stiffness of the primary suspension over one wheelset";
  parameter Types.Damping c_primary = 2.4e4 "Damping of the primary suspension over one wheelset";
  Types.Length dz[2](each start=0, each fixed=true, each stateSelect=StateSelect.always)
    "Deflection of the primary suspension over each wheelset, change from static, compression positive";
  Types.Velocity ddz[2](each start=0, each fixed=true, each stateSelect=StateSelect.always) "Rate of the deflection";
protected
  Types.Force spring[2] "Spring and damper force over each wheelset, change from static";
  Types.Torque tipping "Torque that tips the frame nose-down, springs excluded";
equation
  spring = k_primary*dz + c_primary*ddz;
  tipping = Components.frameTorque(
    force, sum(torque), acceleration, sum(m_unsprung), m_frame, h_frame, h_rod, sum(r_wheel)/n_groups);
  der(dz) = ddz;
  der(ddz[1]) = Components.deflectionAcceleration(tipping, spring[1], spring[2], m_frame, I_frame, wheelbase/2);
  der(ddz[2]) = Components.deflectionAcceleration(tipping, spring[2], spring[1], m_frame, I_frame, -wheelbase/2);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Line(points={{-80, -40}, {-30, 30}, {20, 0}, {80, 50}}, color={0, 0, 127}),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>In braking the front wheelset gains the load that the rear one loses; the frame bounces and pitches.</p>
<h4>Limitations</h4>
<p>
Those of <a href=\"modelica://RailBraking.Vehicles.PartialGroupPrediction\">PartialGroupPrediction</a> and of
<a href=\"modelica://RailBraking.Components.deflectionAcceleration\">deflectionAcceleration</a>.
</p>
</html>"));
end PartialBogiePrediction;
