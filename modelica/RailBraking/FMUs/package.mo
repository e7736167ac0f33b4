within RailBraking;
package FMUs "Wheel-rail contacts without a vehicle, exported for programs that need only them"
  annotation (Documentation(info="<html>
<p>
Blocks without states. They evaluate the same contact as the plants and the predictions do, so that reports and the
calculation of ideal braking distances need no contact model of their own.
</p>
</html>"));
end FMUs;
