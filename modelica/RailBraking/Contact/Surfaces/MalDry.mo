within RailBraking.Contact.Surfaces;
record MalDry "Dry rail of Mal and others"
  extends Parameters(k_A=1.0, k_S=1.0, mu0=0.46, A=0.4, B=0.6);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Documentation(info="<html>
<p>
Mal, Hussain, Chowdhry and Memon (2020), contact condition dry. k_A = k_S = 1 has no loss of stiffness: peaks lie at a
very small slip.
</p>
</html>"));
end MalDry;
