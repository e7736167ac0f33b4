within RailBraking.Examples;
model WanderingWheelset "A wheelset on wavy dry track, and three predictions of it without readings"
  extends Icons.Example;
  parameter Types.Velocity v = 25 "Speed along the track";
  parameter Types.Length amplitude = 3e-3 "Of the track";
  parameter Types.Frequency f = 1 "Frequency at which the wheelset passes the waves";
  parameter Contact.Surfaces.MalDry rail "Rail"
    annotation(Placement(transformation(extent={{-73, 20}, {-33, 60}})));
  Plants.LateralWheelset plant(start_speed=v, rolling_creep=0) "Wheelset"
    annotation(Placement(transformation(extent={{-20, 20}, {20, 60}})));
  Predictions.LateralPrediction known(mu0_start=rail.mu0, A_falling=rail.A, B_falling=rail.B)
    "Prediction that knows the track"
    annotation(Placement(transformation(extent={{33, 20}, {73, 60}})));
  Predictions.LateralPredictionUnknownTrack unknown(mu0_start=rail.mu0)
    "Prediction that knows the spectrum of the track"
    annotation(Placement(transformation(extent={{-73, -60}, {-33, -20}})));
  Predictions.LateralReconstruction reconstruction(friction_start=rail.mu0)
    "Reconstruction with the five states of the paper, on the plant's position and angle"
    annotation(Placement(transformation(extent={{-20, -60}, {20, -20}})));
  FMUs.LateralContact point(A_falling=rail.A, B_falling=rail.B) "The contact alone"
    annotation(Placement(transformation(extent={{33, -60}, {73, -20}})));
  Predictions.LateralPredictionStiffness known_stiffness(mu0_start=rail.mu0, A_falling=rail.A, B_falling=rail.B)
    "Prediction that knows the track, with the creep stiffness as a state"
    annotation(Placement(transformation(extent={{-73, -110}, {-33, -70}})));
  Predictions.LateralPredictionStiffnessUnknownTrack unknown_stiffness(mu0_start=rail.mu0)
    "Prediction that knows the spectrum of the track, with the creep stiffness as a state"
    annotation(Placement(transformation(extent={{-20, -110}, {20, -70}})));
protected
  Types.Length track "Lateral position of the track";
  Types.Velocity track_rate "Its derivative";
  constant Types.AngularVelocity turn = 2*3.14159265358979 "One turn a second";
equation
  track = amplitude*(1 - cos(turn*f*time));
  track_rate = amplitude*turn*f*sin(turn*f*time);
  plant.track = track;
  plant.mu0 = rail.mu0;
  plant.A_falling = rail.A;
  plant.B_falling = rail.B;
  plant.motor_torque = 0;
  known.track = track;
  known.speed = v;
  unknown.speed = v;
  known_stiffness.track = track;
  known_stiffness.speed = v;
  unknown_stiffness.speed = v;
  reconstruction.lateral_position = plant.lateral_position;
  reconstruction.yaw_angle = plant.yaw_angle;
  reconstruction.track = track;
  reconstruction.track_rate = track_rate;
  reconstruction.speed = v;
  reconstruction.mu0 = rail.mu0;
  reconstruction.A_falling = rail.A;
  reconstruction.B_falling = rail.B;
  point.displacement = known.y - track;
  point.lateral_velocity = known.dy;
  point.yaw_angle = known.psi;
  point.yaw_rate = known.dpsi;
  point.mu0 = exp(known.log_mu0);
  point.stiffness = 1;
  point.speed = v;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    experiment(StopTime=3, Tolerance=1e-8, Interval=0.001),
    Documentation(info="<html>
<p>
<code>known</code> follows the plant, whose creepages are those of lateral and yaw motion alone; <code>unknown</code>
remains at rest, because without readings it has no information on the irregularity.
</p>
</html>"));
end WanderingWheelset;
