within RailBraking.Interfaces;
connector TranslationalFlange "Mechanical connection along the track"
  Types.Velocity v "Speed along the track, forward";
  flow Types.Force f "Force that acts on the component, forward";
  annotation(
    Icon(graphics={Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127},
      fillColor={0, 0, 127}, fillPattern=FillPattern.Solid)}),
    Documentation(info="<html>
<p>
Connected flanges have the same speed, and the forces on their components add up to zero. The
potential variable is the speed, not the position, so that nothing must be differentiated and no
component needs the position of the train.
</p>
</html>"));
end TranslationalFlange;
