within RailBraking.Pneumatics;
block PrescribedPressure "Cylinders whose pressure is the command itself"
  extends Interfaces.PartialCylinder;
equation
  pressure = command;
  air_flow = 0;
  annotation (Documentation(info="<html>
<p>The cylinder that does nothing: for validation, and where the pressure was measured.</p>
<h4>Limitations</h4>
<p>No lag, no bound, no air counted; <code>p_max</code>, <code>V</code> and <code>p_start</code> have no effect.</p>
</html>"));
end PrescribedPressure;
