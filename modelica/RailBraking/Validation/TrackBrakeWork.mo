within RailBraking.Validation;
model TrackBrakeWork "A track brake has a delay, and its friction falls with speed"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=1e-5);

  Components.MagneticTrackBrake brake(
    n_magnets=4, F_attraction=60e3, mu_stand=0.2, mu_fast=0.08, v_friction=8, v_min=5, delay=0.3, T=0.1)
    "Four magnets";
  Types.Velocity v "Speed, falling evenly";
  Types.Ratio field "Closed form of the attraction";
  Types.Force exact "Closed form";
equation
  v = 20 - 2*time;
  brake.command = if time >= 1 then 1 else 0;
  brake.speed = v;
  field = if time < 1.3005 then 0 elseif time < 7.5 then 1 - exp(-(time - 1.3005)/0.1) else exp(-(time - 7.5)/0.1);
  exact = 4*60e3*field*(0.08 + 0.12/(1 + v/8));
  error = (brake.force - exact)/48e3;
  annotation (
    experiment(StopTime=9, Tolerance=1e-8, Interval=0.01),
    Documentation(info="<html>
<p>Switched on at 1 s from 72 km/h, off below 5 m/s; in between, the law of friction over speed.</p>
</html>"));
end TrackBrakeWork;
