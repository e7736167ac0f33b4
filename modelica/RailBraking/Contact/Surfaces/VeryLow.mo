within RailBraking.Contact.Surfaces;
record VeryLow "Rail with hardly any adhesion"
  extends Parameters(k_A=0.3, k_S=0.1, mu0=0.03, A=0.4, B=0.1);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Documentation(info="<html>
<p>The very low level of the family named in LowAdhesion. Medium to low confidence.</p>
</html>"));
end VeryLow;
