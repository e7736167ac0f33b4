package SimpleTrain "Trains of any number of equal wheelsets, made of parts of RailBraking"
  annotation (
    version="1.0.0",
    uses(RailBraking(version="0.2.0")),
    Documentation(info="<html>
<p>
A library of one's own beside <code>RailBraking</code>: the pattern for bringing a train as Modelica. Inputs, outputs and
parameters have the names that the loop knows, so that a scenario needs no table of names.
</p>
</html>"));
end SimpleTrain;
