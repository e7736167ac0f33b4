within RailBraking.Components;
block Blending "Electrodynamic brake first, friction brake for the rest"
  extends Icons.Component;
  parameter Integer n(min=1) = 2 "Number of units: axles, bogies or cars";
  parameter Types.Ratio share[n](each min=0) = fill(1/n, n)
    "Share of each unit in the electrodynamic force; their sum is 1";
  Interfaces.RealInput demand[n](each final unit="N") "Demanded brake force of each unit"
    annotation(Placement(transformation(extent={{-120, 50}, {-100, 70}})));
  Interfaces.RealInput kept[n](each final unit="1") "Share of the demand that wheel-slide protection allows each unit"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.RealInput available(final unit="N") "Maximum force of the electrodynamic brake"
    annotation(Placement(transformation(extent={{-120, -70}, {-100, -50}})));
  Interfaces.RealInput dynamic_force(final unit="N") "Actual force of the electrodynamic brake"
    annotation(Placement(transformation(extent={{-10, -120}, {10, -100}})));
  Interfaces.RealOutput dynamic_demand(final unit="N") "Demanded force of the electrodynamic brake"
    annotation(Placement(transformation(extent={{100, 40}, {120, 60}})));
  Interfaces.RealOutput friction[n](each final unit="N") "Demanded force of the friction brake of each unit"
    annotation(Placement(transformation(extent={{100, -60}, {120, -40}})));
protected
  Types.Force wanted[n] "Force of each unit, after wheel-slide protection";
  Types.Force most[n] "Electrodynamic force at which a unit does not exceed its demand";
equation
  for i in 1:n loop
    wanted[i] = kept[i]*demand[i];
    most[i] = wanted[i]/noEvent(max(share[i], 1e-9));
    friction[i] = noEvent(max(wanted[i] - share[i]*dynamic_force, 0));
  end for;
  dynamic_demand = noEvent(min(min(most), available));
initial equation
  assert(abs(sum(share) - 1) < 1e-6, "Blending: the shares must sum to 1, got " + String(sum(share)) + ".");
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-60, 60}, {60, 0}}, lineColor={0, 0, 127}),
        Rectangle(extent={{-60, 0}, {60, -60}}, lineColor={0, 0, 127}, fillColor={0, 0, 127},
fillPattern=FillPattern.Solid)}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
A unit is an axle, a bogie or a car that blends separately. Its friction brake provides what the
electrodynamic brake does not; trailer units have the share zero:
</p>
<blockquote><pre>
dynamic_demand = min(available, min(kept[i] demand[i]/share[i]))
friction[i] = kept[i] demand[i] - share[i] dynamic_force
</pre></blockquote>
<p>
Thus no unit exceeds its demand, and the sum of friction and electrodynamic force is the demand for
any electrodynamic force. Wheel-slide protection lowers both: one sliding unit lowers the
electrodynamic force of all units of the inverter, and their friction brakes compensate.
</p>
<h4>Limitations</h4>
<p>
The friction brake responds late, so that the sum drops for some tenths of a second while the
electrodynamic brake fades; this is not anticipated. The electrodynamic brake of motored units does
not brake for trailers.
</p>
</html>"));
end Blending;
