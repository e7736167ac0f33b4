within RailBraking.Contact.Surfaces;
record MalWorst "Worst adhesion of Mal and others"
  extends Parameters(k_A=1.0, k_S=1.0, mu0=0.1, A=0.1, B=0.2);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Documentation(info="<html>
<p>As MalDry, worst condition.</p>
</html>"));
end MalWorst;
