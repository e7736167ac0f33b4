within RailBraking.Interfaces;
partial model PartialValidation "A model that knows its answer and judges itself"
  extends Icons.Component;
  parameter Types.Ratio tolerance "Largest error that passes";
  Types.Ratio error "Deviation from the closed form, relative to the size of the answer";
equation
  assert(abs(error) <= tolerance, "The answer is off by " + String(error) + ", more than " + String(tolerance) + ".");
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>The simulation stops with a message where the error leaves the tolerance.</p>
</html>"));
end PartialValidation;
