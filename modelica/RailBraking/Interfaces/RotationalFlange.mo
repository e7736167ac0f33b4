within RailBraking.Interfaces;
connector RotationalFlange "Mechanical connection about an axle"
  Types.AngularVelocity w "Angular velocity about the axle, forward";
  flow Types.Torque tau "Torque that acts on the component, forward";
  annotation(
    Icon(graphics={Ellipse(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127},
      fillColor={0, 0, 127}, fillPattern=FillPattern.Solid)}),
    Documentation(info="<html>
<p>
Connected flanges move alike, and the torques on what they belong to add up to zero. Its potential is the angular
velocity, not the angle: nothing needs to be differentiated, and no part needs to know where a mark on the wheel is.
</p>
</html>"));
end RotationalFlange;
