within RailBraking.Contact;
function warmFriction "Friction of a contact that its own slip heats"
  extends Icons.Function;
  input Types.Ratio mu_cold "Friction at the temperature of the rail";
  input Types.Force Q "Load of the wheel, positive";
  input Types.Velocity slip_speed "Speed of the wheel over the rail";
  input Types.ThermalResistance R_wheel "Result of flashResistance for the wheel";
  input Types.ThermalResistance R_rail "Result of flashResistance for the rail";
  input Types.TemperatureDifference rise "Temperature of the tread above that of the rail, away from the contact";
  input Types.TemperatureCoefficient temperature_loss "Share of friction lost a kelvin";
  output Types.Ratio mu "Friction at the temperature of the contact";
protected
  constant Types.Velocity w_small = 1e-3 "Rounding about no slip speed";
  Types.Velocity w "Magnitude of the slip speed, rounded";
  Types.Ratio touch "Share of the rise that two bodies have where they touch, without friction";
  Types.ThermalResistance R "Temperature rise of the contact over all of its heat";
algorithm
  w := sqrt(slip_speed^2 + w_small^2);
  touch := R_rail/(R_wheel + R_rail);
  R := R_wheel*R_rail/(R_wheel + R_rail);
  mu := mu_cold*(1 - temperature_loss*touch*rise)/(1 + temperature_loss*mu_cold*R*Q*w);
  annotation (
    smoothOrder=100,
    Inline=true,
    Documentation(info="<html>
<p>
Friction falls linearly with the mean temperature T of the contact, mu = mu_cold (1 - temperature_loss (T - T_rail)).
That friction falls at high temperature explains measured creep curves (Ertz, Creep force laws for wheel/rail contact
with temperature-dependent coefficient of friction, 2002). T is T_rail + touch rise + R mu Q w by the slip power
mu Q w. Both are linear in mu, and this is their solution: without iteration, and positive at any slip speed.
</p>
<p>
Heat divides so that both bodies have one mean temperature in the contact (Blok's postulate): the share
R_rail/(R_wheel + R_rail) goes into the wheel, and in addition rise/(R_wheel + R_rail) flows from a hot tread into
the rail.
</p>
<h4>Syntax</h4>
<blockquote><pre>
mu = Contact.<strong>warmFriction</strong>(mu_cold, Q, slip_speed, R_wheel, R_rail, rise, temperature_loss);
</pre></blockquote>
<h4>Limitations</h4>
<p>
The slip power is that of full sliding; below the maximum of the creep curve it is too high, where it heats the contact
by a few kelvin. The tread must stay below 1/temperature_loss above the rail. Softening, melting and the transformation
of steel into martensite are not in it.
</p>
</html>"));
end warmFriction;
