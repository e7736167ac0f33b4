within RailBraking.Pneumatics;
model DriversBrakeValve "Valve that controls the pressure of the brake pipe"
  extends Icons.Pneumatic;
  parameter Real C_fill(final unit="m3/(s.Pa)") = 1.5e-7 "Sonic conductance when filling";
  parameter Real C_vent(final unit="m3/(s.Pa)") = 1e-7 "Sonic conductance of service braking";
  parameter Real C_emergency(final unit="m3/(s.Pa)") = 8e-7 "Sonic conductance of the emergency opening";
  parameter Types.Pressure p_emergency = 5e4 "Demand below which the emergency opening is open";
  parameter Types.Pressure p_band = 2e4 "Deviation at which it is fully open";
  parameter Types.Volume V = 1e-3 "Volume of the pipe at the valve";
  parameter Types.Pressure p_start = 5e5 "Pressure at the start";
  Interfaces.RealInput demand(final unit="Pa") "Pressure that the pipe should have; zero for emergency"
    annotation(Placement(transformation(extent={{-10, 100}, {10, 120}})));
  Interfaces.AirPort supply "Main reservoir"
    annotation(Placement(transformation(extent={{-120, -10}, {-100, 10}})));
  Interfaces.AirPort pipe "Brake pipe"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
protected
  Types.Pressure p(start=p_start, fixed=true) "Pressure at the valve";
  Types.VolumeFlow filling "Free air from the main reservoir";
  Types.VolumeFlow venting "Free air into the atmosphere";
equation
  filling = orificeFlow(
    C_fill*noEvent(min(max((demand - p)/p_band, 0), 1)), noEvent(max(supply.p, p)), p);
  venting = orificeFlow(
    C_vent*noEvent(min(max((p - demand)/p_band, 0), 1)) + noEvent(if demand < p_emergency then C_emergency else 0),
    p, 0);
  V/p_free*der(p) = filling - venting + pipe.q;
  pipe.p = p;
  supply.q = filling;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Ellipse(extent={{-50, 50}, {50, -50}}, lineColor={0, 0, 127}),
        Line(points={{0, 0}, {30, 90}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
A relay valve: it opens in proportion to the deviation, up to its conductance. Full service is 3.5 bar in a pipe of
5 bar. Conductances are
estimated: service braking lowers 300 m of pipe by 1.5 bar in some seconds, the emergency opening is that of a pipe
of one inch.
</p>
<h4>Limitations</h4>
<p>No overcharge and no equalising reservoir: the pressure follows a step of the demand as fast as
the conductance allows.</p>
</html>"));
end DriversBrakeValve;
