within RailBraking.Pneumatics;
model BrakePipe "Brake pipe through a train, in cells"
  extends Icons.Pneumatic;
  parameter Integer n(min=1) = 2 "Number of cells";
  parameter Types.Length length[n](each start=26.4/5) "Length of pipe in each cell";
  parameter Types.Length D = 0.032 "Inner diameter";
  parameter Types.Ratio friction = 0.03 "Darcy friction factor, with couplings and bends";
  parameter Types.Volume V_branch[n] = fill(0, n) "Volume of branch pipe and dirt collector at each cell";
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
  constant Types.Velocity c = sqrt(p_free/rho_free) "Isothermal speed of sound";
  final parameter Types.Area A = 3.141592653589793/4*D^2 "Cross section";
  final parameter Types.Length x[n] = cat(1, {length[1]/2}, {(length[i - 1] + length[i])/2 for i in 2:n})
    "Distance of the middle of each cell from that of the one ahead, or from the leading end";
  Types.Pressure p[n](each start=p_start, each fixed=true) "Pressure in each cell";
  Types.VolumeFlow q[n](each start=0, each fixed=true, each nominal=1e-2)
    "Free air that flows to the rear in each cell";
  Real slope_p[n + 1](each final unit="Pa/m") "Slope of the pressure at each face, leading end first";
  Real slope_q[n + 1](each final unit="m2/s") "Slope of the flow at each face";
  Types.Pressure P_before[n] "Absolute pressure at the leading face of each cell, from inside";
  Types.Pressure P_behind[n] "Absolute pressure at the trailing face of each cell, from inside";
  Types.VolumeFlow q_before[n] "Flow at the leading face of each cell, from inside";
  Types.VolumeFlow q_behind[n] "Flow at the trailing face of each cell, from inside";
  Types.Velocity u_before[n] "Speed of the air at the leading face of each cell, from inside";
  Types.Velocity u_behind[n] "Speed of the air at the trailing face of each cell, from inside";
  Types.Velocity u[n + 1] "Speed of the air at each face";
  Types.VolumeFlow air[n + 1] "Free air through each face";
  Real momentum[n + 1](each final unit="m4/s2") "Momentum through each face, with the pressure on it, over rho_free";
  Types.Pressure P_rear "Absolute pressure on the trailing end";
  Types.PressureRate p_rate[n] "Rate of the pressure in each cell";
  Types.VolumeFlow taken[n] "Free air into the branches, with its speed in the pipe";
equation
  front.p = p[1] - x[1]*slope_p[1];
  front.q = air[1];
  rear.p = p[n];
  rear.q = -air[n + 1];
  for i in 2:n loop
    slope_p[i] = (p[i] - p[i - 1])/x[i];
    slope_q[i] = (q[i] - q[i - 1])/x[i];
  end for;
  slope_p[n + 1] = slope_p[n];
  slope_q[n + 1] = (air[n + 1] - q[n])/(length[n]/2);
  slope_q[1] = slope_q[2];
  for i in 1:n loop
    P_before[i] = p[i] + p_free - length[i]*(2*slope_p[i] + slope_p[i + 1])/6;
    P_behind[i] = p[i] + p_free + length[i]*(slope_p[i] + 2*slope_p[i + 1])/6;
    q_before[i] = q[i] - length[i]*(2*slope_q[i] + slope_q[i + 1])/6;
    q_behind[i] = q[i] + length[i]*(slope_q[i] + 2*slope_q[i + 1])/6;
    u_before[i] = p_free*q_before[i]/(A*P_before[i]);
    u_behind[i] = p_free*q_behind[i]/(A*P_behind[i]);
  end for;
  u[1] = u_before[1] + c*log((front.p + p_free)/P_before[1]);
  air[1] = A*u[1]*(front.p + p_free)/p_free;
  momentum[1] = air[1]*u[1] + A/rho_free*(front.p + p_free);
  for i in 2:n loop
    u[i] = (u_behind[i - 1] + u_before[i])/2;
    air[i] = ((c + u[i])*q_behind[i - 1] + (c - u[i])*q_before[i]
      - (c^2 - u[i]^2)*A/p_free*(P_before[i] - P_behind[i - 1]))/(2*c);
    momentum[i] = ((c + u[i])*(u_behind[i - 1]*q_behind[i - 1] + A/rho_free*P_behind[i - 1])
      + (c - u[i])*(u_before[i]*q_before[i] + A/rho_free*P_before[i])
      - (c^2 - u[i]^2)*(q_before[i] - q_behind[i - 1]))/(2*c);
  end for;
  P_rear = P_behind[n] + c*rho_free/A*(q_behind[n] - air[n + 1]);
  u[n + 1] = p_free*air[n + 1]/(A*P_rear);
  momentum[n + 1] = air[n + 1]*u[n + 1] + A/rho_free*P_rear;
  for i in 1:n loop
    p_rate[i] = p_free/(A*length[i] + V_branch[i])*(air[i] - air[i + 1] + branch[i].q);
    der(p[i]) = p_rate[i];
    taken[i] = noEvent(max(V_branch[i]/p_free*p_rate[i] - branch[i].q, 0));
    length[i]*der(q[i]) = momentum[i] - momentum[i + 1]
      - p_free*(friction*length[i]/(2*D)*sqrt(q[i]^2 + q_small^2) + taken[i])*q[i]/(A*(p[i] + p_free));
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
<p>
Mass and momentum of isothermal air, with the free air q that flows to the rear, the absolute pressure P and the speed
u = p_free q/(A P):
</p>
<blockquote><pre>
A/p_free dP/dt + dq/dx = q(branch)
dq/dt + d(u q + A P/rho_free)/dx = -friction/(2 D) u |q|
</pre></blockquote>
<p>
The speed of small waves is sqrt(p_free/rho_free) = 290 m/s, the isothermal speed of sound. A branch
of the volume V_branch every L metres reduces it to 290 m/s/sqrt(1 + V_branch/(A L)). Air enters a
branch with the momentum that it has in the pipe. Brake pipes have 25 to 32 mm (EN 15355: at most 25
l in a vehicle of at most 31 m).
</p>
<h4>Implementation</h4>
<p>
Finite volumes. Pressure and flow at the faces of a cell are parabolas through three cells (upwind-biased, third order),
the fluxes between two cells those of Harten, Lax and van Leer with the speeds u - c and u + c. No
limiter is needed, because braking causes rarefactions, which spread. At the leading end the
pressure is that of the port, and the wave that leaves the pipe conserves u - c ln P; at the
trailing end the flow is that of the port.
</p>
<p>
The front of an emergency brake, a fall by some 0.1 bar, through a locomotive and ten coaches with branches of 3 l has a
speed of 249 m/s with three or more cells per car; without branches, where it remains sharper, 270,
268 and 266 m/s with 3, 9 and 17 cells per car. The tests compare five cells per car with an
independent solver on finer grids.
</p>
<h4>Limitations</h4>
<p>
The friction factor is constant and estimated. Only an <a
href=\"modelica://RailBraking.Pneumatics.Accelerator\">Accelerator</a> at a branch accelerates the
brake. A branch is a volume at a point, without resistance between it and the pipe. The flow must be
subsonic.
</p>
</html>"));
end BrakePipe;
