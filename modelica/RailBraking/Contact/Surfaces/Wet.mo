within RailBraking.Contact.Surfaces;
record Wet "Wet rail"
  extends Parameters(k_A=0.3, k_S=0.1, mu0=0.30, A=0.4, B=0.2);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Documentation(info="<html>
<p>Polach (2005), typical parameters for wet conditions.</p>
</html>"));
end Wet;
