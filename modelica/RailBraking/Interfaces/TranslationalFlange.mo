within RailBraking.Interfaces;
connector TranslationalFlange "Mechanical connection along the track"
  Types.Velocity v "Speed along the track, forward";
  flow Types.Force f "Force that acts on the component, forward";
  annotation(
    Icon(graphics={Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127},
      fillColor={0, 0, 127}, fillPattern=FillPattern.Solid)}),
    Documentation(info="<html>
<p>
Connected flanges move alike, and the forces on what they belong to add up to zero. Its potential is the speed, not
the position: nothing needs to be differentiated, and no part needs to know where the train is.
</p>
</html>"));
end TranslationalFlange;
