package RailBraking "Railway braking at low adhesion: contact, pads, pneumatics, bogies and the trains made of them"
  constant Types.Acceleration g = 9.81 "Acceleration of gravity";
  annotation (
    version="0.2.0",
    Documentation(info="<html>
<p>
Plants and prediction models for research on wheel-slide protection and adhesion estimation. The classes of
<a href=\"modelica://RailBraking.Plants\">Plants</a>, <a
href=\"modelica://RailBraking.Predictions\">Predictions</a> and <a
href=\"modelica://RailBraking.FMUs\">FMUs</a> become FMUs; the other packages have their components.
Start with the <a href=\"modelica://RailBraking.UsersGuide\">User's Guide</a>.
</p>
<p>The library does not depend on any other library, not even on the Modelica Standard Library.</p>
</html>"));
end RailBraking;
