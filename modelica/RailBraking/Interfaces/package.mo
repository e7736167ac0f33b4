within RailBraking;
package Interfaces "Signals, and what each kind of part has in common"
  annotation (Documentation(info="<html>
<p>
Parts exchange signals, not physical connectors: the longitudinal masses of a train share one speed, so that a
connector with a flow would only add constraints for a tool to remove again.
</p>
</html>"));
end Interfaces;
