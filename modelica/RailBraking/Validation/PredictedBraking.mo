within RailBraking.Validation;
model PredictedBraking "Deceleration of rig and wagon follows from adhesion and masses"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-6);

  parameter Types.Ratio alpha = 0.08 "Constant adhesion";
  Predictions.RollerRigPrediction rig(start_speed=30, alpha_start=alpha, A_drag=0)
    "One wheelset, imitating a wagon of two";
  Predictions.WagonPrediction wagon(start_speed=30, alpha_start=alpha, A_drag=0) "Both wheelsets brake";
  Predictions.WagonPrediction printed(
    start_speed=30, alpha_start=alpha, A_drag=0, adhesion_share=0.5, resistance_transfer=1, adhesion_transfer=0)
    "As equation (12) is printed";
protected
  final parameter Types.Force shift = 1.5/9*alpha*40e3*g "Load that moves to the front wheelset";
equation
  rig.pad_force = 10e3;
  wagon.pad_force = {10e3, 10e3};
  wagon.track_force = 0;
  wagon.wheel_torque = {0, 0};
  printed.pad_force = {10e3, 10e3};
  printed.track_force = 0;
  printed.wheel_torque = {0, 0};
  error = max({
    abs(rig.v - (30 - alpha*g/2*time)), abs(wagon.v - (30 - alpha*g*time)),
    abs(printed.v - (30 - alpha*g/2*time)),
    abs(wagon.w[1] - wagon.w[2] - 2*0.46*alpha*shift/130*time), abs(printed.w[1] - printed.w[2])})/30;
  annotation (
    experiment(StopTime=5, Tolerance=1e-9, Interval=0.01),
    Documentation(info="<html>
<p>
Without drag the deceleration of the wagon is alpha g; that of the rig, which imitates it with one
braked wheelset, and of the wagon with the printed factor is half of it. The front wheelset is
accelerated by its greater load.
</p>
</html>"));
end PredictedBraking;
