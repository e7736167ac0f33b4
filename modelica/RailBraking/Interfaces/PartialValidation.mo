within RailBraking.Interfaces;
partial model PartialValidation "A model that knows its answer and judges itself"
  parameter Types.Ratio tolerance "Largest error that passes";
  Types.Ratio error "Deviation from the closed form, relative to the size of the answer";
equation
  assert(abs(error) <= tolerance, "The answer is off by " + String(error) + ", more than " + String(tolerance) + ".");
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>The simulation stops with a message where the error leaves the tolerance.</p>
</html>"));
end PartialValidation;
