within RailBraking.Vehicles;
block GroupPrediction "A group of wheelsets as an estimator believes it to be, without suspension"
  extends PartialGroupPrediction(final n_groups=1);
  parameter Types.Mass m_group(min=1e-3) = 15e3 "Mass that the group carries on the rail, its own included";
equation
  load = {g*m_group};
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
<p>Three states: w, mu_b, alpha. Free of events.</p>
<h4>Limitations</h4>
<p>
The load is static: what braking shifts of it, the estimate shows as adhesion. Otherwise those of
<a href=\"modelica://RailBraking.Vehicles.PartialGroupPrediction\">PartialGroupPrediction</a>.
</p>
</html>"));
end GroupPrediction;
