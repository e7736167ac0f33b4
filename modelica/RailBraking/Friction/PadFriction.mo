within RailBraking.Friction;
block PadFriction "Pads whose friction follows temperature, speed and pressure"
  extends Icons.Component;
  extends Interfaces.PartialPadFriction(mu(start=mu_start, fixed=true));
  output Types.Ratio mu_steady "Friction that the present conditions lead to";
protected
  Real rate(final unit="1/s") "Rate at which friction settles";
equation
  mu_steady = mu_nominal*(1 + speed_effect*(1 - pad_speed/pad_speed_nominal))
    *(1 + temperature_effect*saturate((temperature - temperature_nominal)/temperature_range))
    *(1 - force_effect*(pad_force/pad_force_nominal - 1));
  rate = sqrt(1/T_settle^2 + (pad_force*pad_speed/E_settle)^2)*pad_force^4/(pad_force^4 + F_release^4);
  der(mu) = rate*(mu_steady - mu);
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
A first-order lag towards a product of three linear effects, in the spirit of Ostermeyer (2003): friction rises
towards standstill and with temperature and falls with pressure; it settles over an amount of friction work, not
over a time, because contact patches must wear in. The coefficients are engineering estimates that reproduce
the trends of published dynamometer and field tests (0.36 rising to 0.40 in an emergency stop from 85 km/h).
</p>
<p>
With released pads there is no friction work and <code>mu</code> keeps its value: the rate vanishes as the fourth
power of
the force below <code>F_release</code>.
</p>
<h4>Limitations</h4>
<p>
Fading above 400 degrees Celsius, wet pads and the scatter between units are not modelled: express them by
<code>mu_nominal</code> and <code>mu_start</code>. The linear speed effect is meant for sliding speeds up to 40 m/s.
</p>
</html>"));
end PadFriction;
