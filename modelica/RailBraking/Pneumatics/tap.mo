within RailBraking.Pneumatics;
function tap "Sample of a delay line"
  input Real line[2](each final unit="1") "Samples as shift keeps them";
  input Types.Ratio age "Whole number of periods since it entered, 0 to 63";
  input Types.Ratio place "Its place value";
  output Types.Ratio y "Sample";
algorithm
  y := mod(floor((if age < 32 then line[1] else line[2])/place), 3) - 1;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Ellipse(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-90, 90}, {90, -90}}, textString="f", textColor={0, 0, 127}),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Documentation(info="<html>
<h4>Syntax</h4>
<blockquote><pre>
y = Pneumatics.<strong>tap</strong>(line, age, place);
</pre></blockquote>
<p>
The place value is that of <a href=\"modelica://RailBraking.Pneumatics.placeValue\">placeValue</a>, taken once when
the age never changes.
</p>
<h4>Limitations</h4>
<p>Ages are whole numbers; beyond 63 there is no sample, and the result means nothing.</p>
</html>"));
end tap;
