within RailBraking.Friction;
block PadFriction "Pads whose friction follows temperature, speed and pressure"
  extends Icons.Component;
  extends Interfaces.PartialPadFriction(mu(start=mu_start, fixed=true, nominal=0.1));
  output Types.Ratio mu_steady "Steady friction at the present conditions";
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
A first-order lag towards a product of three linear effects: friction rises towards standstill and with the temperature
of the disc, and falls with pad force. It settles over an amount of friction work, not over a time, because contact
patches must wear in, as in the model of Ostermeyer (2003). In an emergency stop of the two-part train from 85 km/h it
rises from 0.36 to 0.40. Schwarz, L&uuml;dicke and Heckmann (2019) report the rise with temperature, Schwarz and Keck
(2020) the rise towards standstill. All coefficients are engineering estimates, and so is the sign of the effect of pad
force.
</p>
<p>
This is a formulation of RailBraking, not the model of Ehret (2021) that Schwarz, Posielek and Goetjes (2021) use. Only
the abstract of Ehret's model was available: it links relative velocity, temperatures and normal pressure of the
contact surfaces to the instantaneous friction, with parameters identified on a full-scale dynamometer, and is verified
by braking distances. This class has neither measured parameters nor temperatures of the contact surfaces.
</p>
<p>
With released pads there is no friction work and <code>mu</code> keeps its value: the rate vanishes as the fourth
power of the force below <code>F_release</code>.
</p>
<h4>Limitations</h4>
<p>
Fading above 400 degrees Celsius, wet pads and the scatter between units are not modelled: express them by
<code>mu_nominal</code> and <code>mu_start</code>. The linear speed effect is meant for sliding speeds up to 40 m/s.
</p>
</html>"));
end PadFriction;
