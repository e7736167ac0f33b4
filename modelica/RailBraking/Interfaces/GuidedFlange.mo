within RailBraking.Interfaces;
connector GuidedFlange "Mechanical connection of six small motions"
  Types.Length x "Position along the track relative to an even run";
  Types.Length y "Lateral position, to the left";
  Types.Length z "Height, change from static";
  Types.Angle phi "Roll angle, left side up";
  Types.Angle theta "Pitch angle, nose down";
  Types.Angle psi "Yaw angle, to the left";
  flow Types.Force X "Force that acts on the component, forward";
  flow Types.Force Y "Force that acts on the component, to the left";
  flow Types.Force Z "Force that acts on the component, upwards, change from static";
  flow Types.Torque M_phi "Torque that acts on the component about the track";
  flow Types.Torque M_theta "Torque that acts on the component across the track";
  flow Types.Torque M_psi "Torque that acts on the component about the vertical axis";
  annotation(
    Icon(graphics={Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127},
      fillColor={127, 127, 127}, fillPattern=FillPattern.Solid)}),
    Documentation(info="<html>
<p>
Connected flanges have the same motion, and the forces and torques on their components add up to zero. Angles are small.
Axes
as in <a href=\"modelica://RailBraking.Components.GuidedWheelset\">GuidedWheelset</a>: x along the track, y to the
left, z upwards.
</p>
</html>"));
end GuidedFlange;
