within RailBraking.Pneumatics;
model Accelerator "Accelerator valve: vents the brake pipe where it stands when its pressure falls fast"
  parameter Real C(final unit="m3/(s.Pa)", min=0) = 2e-7 "Sonic conductance of the vent, about 1 cm2";
  parameter Types.PressureRate rate_open(min=1) = 5e4 "Fall of the pressure at which it opens";
  parameter Types.Pressure p_close = 2.5e5 "Pressure of the pipe at which it closes again";
  parameter Types.Time T_sense(min=1e-3) = 0.05 "Time over which the fall is sensed";
  parameter Types.Pressure p_start = 5e5 "Pressure of the pipe at the start";
  Interfaces.AirPort pipe "Brake pipe"
    annotation(Placement(transformation(extent={{-10, 100}, {10, 120}})));
  Interfaces.BooleanOutput open(start=false, fixed=true) "= true, if it vents"
    annotation(Placement(transformation(extent={{100, -10}, {120, 10}})));
protected
  Types.Pressure p(start=p_start, fixed=true) "Pressure behind the sensing choke";
equation
  T_sense*der(p) = pipe.p - p;
  open = if pre(open) then pipe.p > p_close else p - pipe.p > T_sense*rate_open and pipe.p > p_close;
  pipe.q = if open then orificeFlow(C, pipe.p, 0) else 0;
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Line(points={{0, 100}, {0, 20}}, color={0, 0, 127}),
        Line(points={{-40, 20}, {40, 20}, {0, -40}, {-40, 20}}, color={0, 0, 127}),
        Line(points={{0, -40}, {0, -80}}, color={0, 0, 127}),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The pressure behind a choke lags that of the pipe by T_sense: a fall at the rate r makes them differ by T_sense r. Where
that exceeds T_sense <code>rate_open</code>, as in an emergency brake and not in a service brake, the valve vents the
pipe of its own vehicle until <code>p_close</code>. Connect <code>pipe</code> with a branch of <a
href=\"modelica://RailBraking.Pneumatics.BrakePipe\">BrakePipe</a>.
</p>
<p>
Unverified in the text of the standards (EN 15612, UIC 541-1): conductance, sensitivity and the pressure at which
it closes are estimated.
</p>
<h4>Limitations</h4>
<p>
It vents in emergency brakes only. It cannot be faster than the front that opens it: behind the front the pressure falls
faster, the front itself runs no faster than sound.
</p>
</html>"));
end Accelerator;
