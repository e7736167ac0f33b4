within RailBraking.Examples;
model BrakePipeOfTenCoaches "Emergency brake of a locomotive with ten coaches through the brake pipe"
  extends Icons.Example;
  constant Integer n = 11 "Vehicles";
  parameter Integer cells = 5 "Cells of the brake pipe in each vehicle; odd, so that a branch is in the middle";
  parameter Types.Volume V_branch = 3e-3 "Volume of the branch of each vehicle";
  parameter Real C_accelerator(final unit="m3/(s.Pa)") = 0 "Sonic conductance of the accelerator of each vehicle";
  Pneumatics.Compressor compressor(q_nominal=0.04) "On the locomotive"
    annotation(Placement(transformation(extent={{-110, 60}, {-90, 80}})));
  Pneumatics.Reservoir main(V=0.8, p_start=9e5) "Main reservoir"
    annotation(Placement(transformation(extent={{-80, 60}, {-60, 80}})));
  Pneumatics.DriversBrakeValve valve "Driver's brake valve"
    annotation(Placement(transformation(extent={{-50, 20}, {-30, 40}})));
  Pneumatics.BrakePipe pipe(n=cells*n, length=cat(1, fill(19.5/cells, cells), fill(26.4/cells, cells*(n - 1))),
    V_branch={if mod(i - 1, cells) == div(cells, 2) then V_branch else 0 for i in 1:cells*n}) "Brake pipe"
    annotation(Placement(transformation(extent={{-10, 20}, {10, 40}})));
  Pneumatics.CheckValve charging[n](each C=5e-9) "From the pipe to each auxiliary reservoir"
    annotation(Placement(transformation(extent={{30, 20}, {50, 40}})));
  Pneumatics.Reservoir auxiliary[n](each V=0.1, each p_start=5e5) "Auxiliary reservoirs"
    annotation(Placement(transformation(extent={{70, 20}, {90, 40}})));
  Pneumatics.Distributor distributor[n] "Distributors in position P"
    annotation(Placement(transformation(extent={{-10, -40}, {10, -20}})));
  Pneumatics.SuppliedCylinder cylinder[n](each V=0.02, each p_max=3.8e5)
    "Brake cylinders with the valves of wheel-slide protection"
    annotation(Placement(transformation(extent={{40, -40}, {60, -20}})));
  Pneumatics.Accelerator accelerator[n](each C=C_accelerator, each rate_open=7e4, each T_sense=0.3)
    "Accelerators, none where they have no conductance"
    annotation(Placement(transformation(extent={{-60, -40}, {-40, -20}})));
  Types.Time front(start=0, fixed=true) "Time at which the last vehicle begins to brake";
  Types.Time full(start=0, fixed=true) "Time at which it reaches 95 % of its full pressure";
equation
  connect(compressor.port, main.port)
    annotation(Line(points={{-89, 70}, {-85, 70}, {-85, 55}, {-70, 55}, {-70, 59}}, color={0, 127, 127}));
  connect(main.port, valve.supply)
    annotation(Line(points={{-70, 59}, {-70, 30}, {-51, 30}}, color={0, 127, 127}));
  connect(valve.pipe, pipe.front)
    annotation(Line(points={{-29, 30}, {-11, 30}}, color={0, 127, 127}));
  for i in 1:n loop
    connect(pipe.branch[cells*(i - 1) + div(cells, 2) + 1], distributor[i].pipe);
    connect(pipe.branch[cells*(i - 1) + div(cells, 2) + 1], charging[i].a);
    connect(pipe.branch[cells*(i - 1) + div(cells, 2) + 1], accelerator[i].pipe);
    connect(charging[i].b, auxiliary[i].port);
    connect(auxiliary[i].port, distributor[i].supply);
    connect(distributor[i].outlet, cylinder[i].supply);
    cylinder[i].command = 1;
  end for;
  valve.demand = if time < 1 then 5e5 else 0;
  when distributor[n].pressure > 1e3 then
    front = time - 1;
  end when;
  when cylinder[n].pressure > 0.95*3.8e5 then
    full = time - 1;
  end when;
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    experiment(StopTime=15, Tolerance=1e-6, Interval=0.01),
    Documentation(info="<html>
<p>
The front reaches the middle of the last coach, 270 m away, after a little more than a second, and
the last coach reaches its full pressure a second after the first. Plot pipe.pressure and
cylinder.pressure. Vary <code>cells</code> to see the effect of the grid on the front.
</p>
</html>"));
end BrakePipeOfTenCoaches;
