within RailBraking.Plants;
block MultiPurposeVehicle "Instrumented car on two bogies that holds its speed on irregular track"
  extends Icons.Vehicle;
  extends Vehicles.MultiPurposeVehicle;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-90, 40}, {90, -40}}, lineColor={0, 0, 127}),
        Ellipse(extent={{-90, -45}, {-60, -75}}, lineColor={0, 0, 127}),
        Ellipse(extent={{-55, -45}, {-25, -75}}, lineColor={0, 0, 127}),
        Ellipse(extent={{25, -45}, {55, -75}}, lineColor={0, 0, 127}),
        Ellipse(extent={{60, -45}, {90, -75}}, lineColor={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Vehicles.MultiPurposeVehicle\">MultiPurposeVehicle</a>.</p>
</html>"));
end MultiPurposeVehicle;
