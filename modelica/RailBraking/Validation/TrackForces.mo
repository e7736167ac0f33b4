within RailBraking.Validation;
model TrackForces "Gradients and curves against numbers calculated by hand"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-3);

equation
  error = max({
    abs(Tracks.gradientForce(84000, 0.01)/(-84000*9.81*0.00999950) - 1),
    abs(Tracks.curveForce(84000, 1/500, 1.9)/(-84000*9.81*0.695e-3) - 1),
    abs(Tracks.curveForceRoeckl(84000, 500)/(-84000*9.81*1.4607e-3) - 1),
    abs(Tracks.curveForceProtopapadakis(84000, 1/500, 1.9)/(-84000*9.81*0.84486e-3) - 1)});
  annotation (
    experiment(StopTime=1, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>At a radius of 500 m the three curve formulas give 0.70, 1.46 and 0.84 per mille.</p>
</html>"));
end TrackForces;
