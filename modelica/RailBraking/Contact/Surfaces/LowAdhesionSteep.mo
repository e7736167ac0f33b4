within RailBraking.Contact.Surfaces;
record LowAdhesionSteep "Contaminated rail with the stiffness of a dry one"
  extends Parameters(k_A=1.0, k_S=0.4, mu0=0.06, A=0.4, B=0.2);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Documentation(info="<html>
<p>As LowAdhesion, but with the reductions 1.0 and 0.4 of a dry rail, which other authors of the same family take. The
peak lies at a much smaller slip.</p>
</html>"));
end LowAdhesionSteep;
