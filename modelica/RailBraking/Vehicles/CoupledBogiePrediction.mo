within RailBraking.Vehicles;
block CoupledBogiePrediction "Bogie of two wheelsets that turn as one, as an estimator believes it to be"
  extends PartialBogiePrediction(final n_groups=1);
equation
  load = {g*sum(m_wheelset) + sum(spring)};
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Line(points={{-80, -40}, {-30, 30}, {20, 0}, {80, 50}}, color={0, 0, 127}),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>Seven states: w, mu_b, alpha, dz, ddz. Free of events.</p>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Vehicles.PartialBogiePrediction\">PartialBogiePrediction</a>.</p>
</html>"));
end CoupledBogiePrediction;
