within RailBraking.Contact.Surfaces;
record LowAdhesion "Contaminated rail with the shape of a wet one"
  extends Parameters(k_A=0.3, k_S=0.1, mu0=0.06, A=0.4, B=0.2);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Documentation(info="<html>
<p>The shape of Wet with less friction, as the group of Pearson, Charles, Ward and Hussain uses it for low adhesion.
The values go from paper to paper without a measurement behind them: medium to low confidence.</p>
</html>"));
end LowAdhesion;
