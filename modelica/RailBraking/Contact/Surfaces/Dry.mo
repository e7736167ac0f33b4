within RailBraking.Contact.Surfaces;
record Dry "Clean dry rail"
  extends Parameters(k_A=1.0, k_S=0.4, mu0=0.55, A=0.4, B=0.6);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Documentation(info="<html>
<p>Polach (2005), typical parameters for dry conditions.</p>
</html>"));
end Dry;
