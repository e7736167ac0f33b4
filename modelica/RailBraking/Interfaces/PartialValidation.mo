within RailBraking.Interfaces;
partial model PartialValidation "A model that compares its result with a known solution"
  extends Icons.Component;
  parameter Types.Ratio tolerance "Maximum permitted error";
  Types.Ratio error "Deviation from the closed form, relative to the solution";
equation
  assert(abs(error) <= tolerance, "The answer is off by " + String(error) + ", more than " + String(tolerance) + ".");
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>The simulation stops with a message if the error exceeds the tolerance.</p>
</html>"));
end PartialValidation;
