within RailBraking;
package FMUs "The blocks that are exported; nothing extends them"
  annotation (Documentation(info="<html>
<p>
Parameters, inputs and outputs are the whole face of a block. Every parameter has a value, because FMI demands one;
whoever runs a scenario sets all of them.
</p>
</html>"));
end FMUs;
