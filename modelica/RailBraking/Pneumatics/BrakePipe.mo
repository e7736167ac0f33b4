within RailBraking.Pneumatics;
model BrakePipe "Brake pipe through a train, one cell to a car"
  extends Icons.Pneumatic;
  parameter Integer n(min=1) = 2 "Number of cells";
  parameter Types.Length length[n](each start=26.4) "Length of pipe in each cell";
  parameter Types.Length D = 0.032 "Inner diameter";
  parameter Types.Ratio friction = 0.03 "Darcy friction factor, with couplings and bends";
  parameter Types.Volume V_branch[n] = fill(0, n) "Of branch pipes and dirt collectors of each cell";
  parameter Types.Pressure p_start = 5e5 "Pressure at the start";
  Interfaces.AirPort front "Leading end"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.AirPort rear "Trailing end"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
  Interfaces.AirPort branch[n] "To the distributor of each car"
    annotation(Placement(transformation(extent={{-10, -120}, {10, -100}})));
  Interfaces.RealOutput pressure[n](each final unit="Pa") "Pressure in each cell"
    annotation(Placement(transformation(extent={{-10, 100}, {10, 120}})));
protected
  constant Types.VolumeFlow q_small = 1e-6 "Flow below which friction is linear";
  final parameter Types.Area A = 3.141592653589793/4*D^2 "Cross section";
  final parameter Types.Length x[n] = cat(1, {length[1]/2}, {(length[i - 1] + length[i])/2 for i in 2:n})
    "From the middle of each cell to the one ahead, or to the end";
  Types.Pressure p[n](each start=p_start, each fixed=true) "Pressure in each cell";
  Types.Pressure ahead[n] "Pressure ahead of each cell";
  Types.VolumeFlow q[n](each start=0, each fixed=true) "Free air from ahead into each cell";
  Types.VolumeFlow on[n] "Free air from each cell to the rear";
equation
  front.p = ahead[1];
  front.q = q[1];
  rear.p = p[n];
  rear.q = -on[n];
  for i in 2:n loop
    ahead[i] = p[i - 1];
    on[i - 1] = q[i];
  end for;
  for i in 1:n loop
    rho_free*x[i]/A*der(q[i]) = ahead[i] - p[i]
      - friction*x[i]*rho_free*p_free/(2*D*A^2)*q[i]*sqrt(q[i]^2 + q_small^2)/((ahead[i] + p[i])/2 + p_free);
    (A*length[i] + V_branch[i])/p_free*der(p[i]) = q[i] - on[i] + branch[i].q;
    branch[i].p = p[i];
    pressure[i] = p[i];
  end for;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 20}, {100, -20}}, lineColor={0, 0, 127}),
        Line(points={{-30, 20}, {-30, -20}}, color={0, 0, 127}),
        Line(points={{30, 20}, {30, -20}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>Mass and momentum of isothermal air, with the free air q that crosses the border of a cell and the absolute
pressure P:</p>
<blockquote><pre>
A dx/p_free dp/dt = q(in) - q(out) + q(branch)
rho_free dx/A dq/dt = p(ahead) - p - friction dx/(2 D) rho_free p_free q |q|/(A^2 P)
</pre></blockquote>
<p>
Waves run at sqrt(p_free/rho_free) = 290 m/s: the isothermal speed of sound, and between the 250 m/s that UIC 540
wants of an emergency
brake and the 300 m/s that good distributors reach. Branches slow it by sqrt(1 + V_branch/(A length)). Steel pipes
of brakes have
25 to 32 mm (EN 15355: at most 25 l in a vehicle of at most 31 m).
</p>
<h4>Limitations</h4>
<p>
The velocity head is neglected (air leaves at up to 100 m/s beside the valve), the friction factor is constant and
estimated. Nothing accelerates the brake but an <a
href=\"modelica://RailBraking.Pneumatics.Accelerator\">Accelerator</a> at a branch. A front is smeared over some cells.
</p>
</html>"));
end BrakePipe;
