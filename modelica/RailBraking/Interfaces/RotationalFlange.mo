within RailBraking.Interfaces;
connector RotationalFlange "Mechanical connection about an axle"
  Types.AngularVelocity w "Angular velocity about the axle, forward";
  flow Types.Torque tau "Torque that acts on the component, forward";
  annotation(
    Icon(graphics={Ellipse(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127},
      fillColor={0, 0, 127}, fillPattern=FillPattern.Solid)}),
    Documentation(info="<html>
<p>
Connected flanges have the same angular velocity, and the torques on their components add up to
zero. The potential variable is the angular velocity, not the angle, so that nothing must be
differentiated and no component needs the angle of a wheel.
</p>
</html>"));
end RotationalFlange;
