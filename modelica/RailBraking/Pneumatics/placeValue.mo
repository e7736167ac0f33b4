within RailBraking.Pneumatics;
function placeValue "Place value of a sample of a delay line"
  input Types.Ratio age "Whole number of periods since it entered, 0 to 63";
  output Types.Ratio place "Place value in the number that holds it";
algorithm
  place := floor(3.0^mod(age, 32) + 0.5);
  annotation (Documentation(info="<html>
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
