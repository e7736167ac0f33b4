within RailBraking.Validation;
model PredictedParts "Bogies and a body make the prediction of the two-part train, rigid groups that of the reduced one"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-6);
  parameter Types.Ratio alpha[4] = {0.12, 0.08, 0.08, 0.12} "Constant adhesion of each group";
  parameter Types.Pressure pressure[4] = {3e5, 2e5, 2e5, 3e5} "Cylinder pressure of each group";
  parameter Types.AngularVelocity w_start = 80/3.6/0.38 "Angular velocity of all wheelsets at the start";
  Predictions.TrainPrediction train(alpha_start=alpha) "With suspension, as a whole";
  Vehicles.BodyPrediction body(m=84000, v(start=80/3.6)) "Its masses along the track";
  Vehicles.PartPrediction front(
    n_bogies=1, group_of_wheelset={1, 1}, w(each start=w_start), alpha(each start=alpha[1]), J={222}, r_wheel={0.38},
    n_units={3}, r_friction={0.235}, m_group={27500}) "Leading bogie, whose wheelsets turn as one";
  Vehicles.PartPrediction middle(
    n_groups=2, n_bogies=1, group_of_wheelset={1, 2}, w(each start=w_start), alpha(each start=alpha[2]), J={209, 209},
    r_wheel={0.38, 0.38}, n_units={2, 2}, r_friction={0.220, 0.220}, m_group={14500, 14500},
    m_unsprung={1300, 1300}, m_frame={2800}, I_frame={2300}, wheelbase={2.65}) "Bogie under both cars";
  Vehicles.PartPrediction rear(
    n_bogies=1, group_of_wheelset={1, 1}, w(each start=w_start), alpha(each start=alpha[4]), J={222}, r_wheel={0.38},
    n_units={3}, r_friction={0.235}, m_group={27500}) "Trailing bogie";
  Vehicles.ConsistPrediction consist(
    n_groups=4, n_bogies=3, group_of_wheelset={1, 1, 2, 3, 4, 4}, v(start=80/3.6),
    w(each start=w_start), alpha(start=alpha), J={222, 209, 209, 222}, r_wheel=fill(0.38, 4), n_units={3, 2, 2, 3},
    r_friction={0.235, 0.220, 0.220, 0.235}, m_group={27500, 14500, 14500, 27500},
    m_unsprung={1500, 1500, 1300, 1300, 1500, 1500}, m_frame={3500, 2800, 3500}, I_frame={2200, 2300, 2200},
    wheelbase={1.9, 2.65, 1.9}) "The same train by data of each group and bogie";
  Vehicles.ConsistPredictionDisturbed disturbed(
    n_groups=4, n_bogies=3, group_of_wheelset={1, 1, 2, 3, 4, 4}, v(start=80/3.6), d(start=0.01),
    w(each start=w_start), alpha(start=alpha), J={222, 209, 209, 222}, r_wheel=fill(0.38, 4), n_units={3, 2, 2, 3},
    r_friction={0.235, 0.220, 0.220, 0.235}, m_group={27500, 14500, 14500, 27500},
    m_unsprung={1500, 1500, 1300, 1300, 1500, 1500}, m_frame={3500, 2800, 3500}, I_frame={2200, 2300, 2200},
    wheelbase={1.9, 2.65, 1.9}) "The same with another acceleration, which a force compensates";
  Predictions.TrainPredictionReduced reduced(alpha_start=alpha) "Without suspension, as a whole";
  Vehicles.PartPrediction group(
    w(each start=w_start), alpha(each start=alpha[1]), J={222}, r_wheel={0.38}, n_units={3}, r_friction={0.235},
    m_group={27500}) "Its leading group";
equation
  train.cylinder_pressure = pressure;
  train.track_force = 1000;
  consist.cylinder_pressure = pressure;
  consist.track_force = 1000;
  disturbed.cylinder_pressure = pressure;
  disturbed.track_force = 1000 - 84000*0.01;
  front.cylinder_pressure = pressure[1:1];
  middle.cylinder_pressure = pressure[2:3];
  rear.cylinder_pressure = pressure[4:4];
  front.acceleration = body.acceleration;
  middle.acceleration = body.acceleration;
  rear.acceleration = body.acceleration;
  body.force = front.force + middle.force + rear.force;
  body.track_force = 1000;
  reduced.cylinder_pressure = pressure;
  reduced.track_force = 1000;
  group.cylinder_pressure = pressure[1:1];
  group.acceleration = reduced.acceleration;
  error = max({
    abs(body.v - train.v)/20, abs(front.w[1] - train.w[1])/50, abs(middle.w[2] - train.w[3])/50,
    abs(rear.w[1] - train.w[4])/50, abs(front.dz[1] - train.dz[1])/1e-3, abs(middle.dz[2] - train.dz[4])/1e-3,
    abs(rear.dz[2] - train.dz[6])/1e-3, abs(group.w[1] - reduced.w[1])/50, abs(consist.v - train.v)/20,
    abs(consist.w[3] - train.w[3])/50, abs(consist.dz[4] - train.dz[4])/1e-3, abs(disturbed.v - train.v)/20,
    abs(disturbed.dz[4] - train.dz[4])/1e-3});
  annotation (
    experiment(StopTime=1, Tolerance=1e-9, Interval=0.001),
    Documentation(info="<html>
<p>
Speed, wheel speeds and deflections of the parts are those of the whole: only the acceleration couples them.
</p>
</html>"));
end PredictedParts;
