within RailBraking.FMUs;
block MultiPurposeVehicle "Instrumented car on two bogies that holds its speed on irregular track"
  extends Vehicles.MultiPurposeVehicle;
  annotation (Documentation(info="<html>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Vehicles.MultiPurposeVehicle\">MultiPurposeVehicle</a>.</p>
</html>"));
end MultiPurposeVehicle;
