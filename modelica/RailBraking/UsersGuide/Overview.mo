within RailBraking.UsersGuide;
class Overview "Structure of the library"
  annotation (
    DocumentationClass=true,
    Documentation(info="<html>
<p>Packages use only those above them:</p>
<table border=\"1\" cellspacing=\"0\" cellpadding=\"2\">
<tr><td>Types</td><td>quantities with units</td></tr>
<tr><td>Interfaces</td><td>signals, physical connections, partial parts</td></tr>
<tr><td>Data</td><td>records of parameters that parts of one kind share</td></tr>
<tr><td>Contact</td><td>Hertz, Kalker, Polach; named surfaces</td></tr>
<tr><td>Friction</td><td>pads and discs</td></tr>
<tr><td>Pneumatics</td><td>cylinders, valves, rigging; brake pipe, distributors, reservoirs, compressor</td></tr>
<tr><td>Components</td><td>wheelsets, brakes, axles, bogies, car bodies, couplers</td></tr>
<tr><td>Tracks</td><td>gradients and curves</td></tr>
<tr><td>Vehicles</td><td>cars, trains and their predictions, which Plants and Predictions complete</td></tr>
<tr><td>Plants</td><td>vehicles and test rigs as simulated, exported as FMUs</td></tr>
<tr><td>Predictions</td><td>vehicles and test rigs as modelled by an estimator, exported as FMUs</td></tr>
<tr><td>FMUs</td><td>wheel-rail contacts without a vehicle, exported as FMUs</td></tr>
<tr><td>Validation, Examples</td><td>closed-form answers; cases to run</td></tr>
</table>
<h4>Examples</h4>
<p>
<a href=\"modelica://RailBraking.Examples.EmergencyStopDry\">EmergencyStopDry</a>,
<a href=\"modelica://RailBraking.Examples.EmergencyStopSlippery\">EmergencyStopSlippery</a>,
<a href=\"modelica://RailBraking.Examples.ProtectedStop\">ProtectedStop</a>,
<a href=\"modelica://RailBraking.Examples.DownhillStop\">DownhillStop</a>,
<a href=\"modelica://RailBraking.Examples.BrakePipeOfTenCoaches\">BrakePipeOfTenCoaches</a>,
<a href=\"modelica://RailBraking.Examples.BlendedStop\">BlendedStop</a>,
<a href=\"modelica://RailBraking.Examples.BrakedWheelset\">BrakedWheelset</a>,
<a href=\"modelica://RailBraking.Examples.CreepCurves\">CreepCurves</a>,
<a href=\"modelica://RailBraking.Examples.PredictedTrain\">PredictedTrain</a>,
<a href=\"modelica://RailBraking.Examples.RollerRigStop\">RollerRigStop</a>,
<a href=\"modelica://RailBraking.Examples.WagonStop\">WagonStop</a>,
<a href=\"modelica://RailBraking.Examples.CoupledCarsStop\">CoupledCarsStop</a>,
<a href=\"modelica://RailBraking.Examples.WanderingWheelset\">WanderingWheelset</a>.
</p>
</html>"));
end Overview;
