within RailBraking.Validation;
model PipeWave "In a wave in a frictionless pipe each pressure has its own speed"
  extends Icons.Validation;
  extends Interfaces.PartialValidation(tolerance=5e-4);

  constant Types.Pressure p_open = 5e5 "Pressure at the start";
  constant Types.Pressure dp = 1e5 "Fall at the leading end";
  constant Types.Time t_fall = 0.55 "Duration of the fall";
  constant Types.Velocity c = sqrt(Pneumatics.p_free/Pneumatics.rho_free) "Speed of sound";
  constant Types.Length dx = 2.5 "Length of a cell";
  constant Types.Length x = 39.5*dx "Distance from the leading end to the middle of the observed cell";
  Pneumatics.BrakePipe pipe(n=80, length=fill(dx, 80), friction=0) "200 m of pipe";
  Pneumatics.PrescribedSupply source "Leading end";
  Types.Velocity speed "Speed of the present pressure";
  Types.Time left "Time at which the present pressure was at the leading end";
  Types.Ratio progress "Progress of the fall";
  Types.Ratio before "Progress of the fall when the present pressure was at the leading end";
equation
  connect(source.port, pipe.front);
  progress = min(time/t_fall, 1);
  source.pressure = p_open - dp*progress^4*(35 - 84*progress + 70*progress^2 - 20*progress^3);
  before = min(max(left/t_fall, 0), 1);
  speed = c*(1 + log((pipe.pressure[40] + Pneumatics.p_free)/(p_open + Pneumatics.p_free)));
  left = time - x/speed;
  error = (pipe.pressure[40] - p_open)/dp + before^4*(35 - 84*before + 70*before^2 - 20*before^3);
  annotation (
    experiment(StopTime=1.02, Tolerance=1e-8, Interval=0.001),
    Documentation(info="<html>
<p>
Riemann: behind a wave into air at rest u = c ln(P/P<sub>0</sub>), and each pressure propagates at u
+ c. The pressure in the cell was at the leading end x/(u + c) ago. The comparison ends before the
wave returns from the closed end.
</p>
</html>"));
end PipeWave;
