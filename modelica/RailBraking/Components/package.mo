within RailBraking;
package Components "Parts of a train: wheelsets, brakes, bogie frames, body"
  annotation (Documentation(info="<html>
<p>
Components have their own states and exchange signals. Masses that move along the track share the speed of their
<a href=\"modelica://RailBraking.Components.CarBody\">CarBody</a>; wheelsets turn on their own.
</p>
</html>"));
end Components;
