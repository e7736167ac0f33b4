within RailBraking.Pneumatics;
function shift "Delay line one period later"
  input Types.Ratio newest "Sample that enters: -1, 0 or 1";
  input Real line[2](each final unit="1") "Samples, 32 to a number";
  output Real shifted[2](each final unit="1") "Samples one period later; the oldest is lost";
protected
  constant Real place = 3.0^31 "Place value of the oldest sample of a number";
  Real moving "Digit that goes from the first number to the second";
algorithm
  moving := floor(line[1]/place);
  shifted[1] := 3*(line[1] - place*moving) + (newest + 1);
  shifted[2] := 3*(line[2] - place*floor(line[2]/place)) + moving;
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
shifted = Pneumatics.<strong>shift</strong>(newest, line);
</pre></blockquote>
<p>
Samples, each plus one, are the digits of whole numbers in base 3, the newest that of the units of the first number. A
Real holds 32 of them exactly, and moving them all takes a few operations.
</p>
<h4>Limitations</h4>
<p>Samples must be -1, 0 or 1; the line holds 64 of them.</p>
</html>"));
end shift;
