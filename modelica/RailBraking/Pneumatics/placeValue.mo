within RailBraking.Pneumatics;
function placeValue "Place value of a sample of a delay line"
  input Types.Ratio age "Whole number of periods since it entered, 0 to 63";
  output Types.Ratio place "Place value in the number that holds it";
algorithm
  place := floor(3.0^mod(age, 32) + 0.5);
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
place = Pneumatics.<strong>placeValue</strong>(age);
</pre></blockquote>
<p>For <a href=\"modelica://RailBraking.Pneumatics.shift\">shift</a>'s lines. Rounded, lest a power of 3 be off by a
digit.</p>
<h4>Limitations</h4>
<p>Ages are whole numbers; beyond 63 there is no sample.</p>
</html>"));
end placeValue;
