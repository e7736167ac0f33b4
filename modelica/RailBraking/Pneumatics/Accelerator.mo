within RailBraking.Pneumatics;
model Accelerator "Accelerator valve: vents the brake pipe locally when its pressure falls fast"
  extends Icons.Pneumatic;
  parameter Real C(final unit="m3/(s.Pa)", min=0) = 2e-7 "Sonic conductance of the vent, about 1 cm2";
  parameter Types.PressureRate rate_open(min=1) = 5e4 "Fall of the pressure at which it opens";
  parameter Types.Pressure p_close = 2.5e5 "Pressure of the pipe at which it closes again";
  parameter Types.Pressure p_ready = 4.5e5 "Pressure of the pipe at which it may open again";
  parameter Types.Time T_sense(min=1e-3) = 0.05 "Time over which the fall is sensed";
  parameter Types.Pressure p_start = 5e5 "Pressure of the pipe at the start";
  Interfaces.AirPort pipe "Brake pipe"
    annotation(Placement(transformation(extent={{-10, 100}, {10, 120}})));
  Interfaces.BooleanOutput open(start=false, fixed=true) "= true, if it vents"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
protected
  Boolean ready(start=true, fixed=true)
    "= true, if it may open: before it has closed, and after the pipe has been filled again";
  Types.Pressure p(start=p_start, fixed=true) "Pressure behind the sensing choke";
equation
  T_sense*der(p) = pipe.p - p;
  ready = if pre(ready) then pipe.p > p_close else pipe.p > p_ready;
  open = ready and (pre(open) or p - pipe.p > T_sense*rate_open);
  pipe.q = if open then orificeFlow(C, pipe.p, 0) else 0;
initial equation
  assert(p_close < p_ready, "Accelerator: p_close must be below p_ready, or it opens and closes without end.");
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Line(points={{0, 100}, {0, 20}}, color={0, 0, 127}),
        Line(points={{-40, 20}, {40, 20}, {0, -40}, {-40, 20}}, color={0, 0, 127}),
        Line(points={{0, -40}, {0, -80}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The pressure behind a choke lags that of the pipe by T_sense: a fall at the rate r makes a
difference of T_sense r. If that exceeds T_sense <code>rate_open</code>, as in an emergency brake
and not in a service brake, the valve vents the
pipe of its own vehicle until <code>p_close</code>. Then it remains closed, even if neighbouring
vehicles refill the pipe, until the pipe reaches <code>p_ready</code>. Connect <code>pipe</code>
with a branch of <a
href=\"modelica://RailBraking.Pneumatics.BrakePipe\">BrakePipe</a>.
</p>
<p>
Not verified against the standards (EN 15612, UIC 541-1): conductance, sensitivity and both
pressures are estimated.
</p>
<h4>Limitations</h4>
<p>
It vents in emergency brakes only. It cannot be faster than the front that opens it: behind the
front the pressure falls faster, but the front itself is not faster than sound. Accelerators keep a
front steep, which requires smaller cells than without them. With one in each of ten coaches with
branches of 3 l, whose small waves run at 272 m/s,
the front runs at 263 m/s in five cells a car and at 258 m/s in 33 where T_sense <code>rate_open</code> is 0.21 bar, at
285 m/s and 270 m/s where it is 0.1 bar, and at 323 m/s and 283 m/s where it is 0.025 bar: in the
last case the foot of the numerically smeared front opens the next accelerator too early.
</p>
</html>"));
end Accelerator;
