within RailBraking.Contact;
block CleaningContact "The two contacts of one wheelset, which slip frees from the film between them"
  extends Icons.Contact;
  extends HeatedContact(
    mu_cold=mu_film + (1 - exp(-removal_rate*energy))*gain,
    removal_share=0.01);
  parameter Types.RemovalRate removal_rate(min=0) = 1.9e-4 "Share of the film removed an energy on a metre of rail";
  parameter Types.Ratio mu_clean(min=0, max=1) = 0.3 "Friction without the film, at the temperature of the rail";
  Types.LineEnergy energy(start=0, fixed=true, nominal=1e3) "Slip energy on a metre of each rail, over the transit";
  Types.Ratio mu_film "Friction of the film";
  Types.Ratio gain "Rise of the friction without the film, rounded to stay positive";
protected
  final parameter Types.Ratio mu_small = 1e-3 "Rounding of the gain by cleaning about zero";
equation
  mu_film = fallingFriction(v - r*w, mu0, curve.A, curve.B);
  gain = (mu_clean - mu_film + sqrt((mu_clean - mu_film)^2 + mu_small^2))/2;
  2*a*der(energy) = F*(v - r*w)/2 - energy*sqrt(v^2 + v_small^2);
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
A wheel of the force F/2 that slips leaves the energy F/2 slip on each metre of its rail. The film that remains in
the contact is e<sup>-removal_rate energy</sup> (Allotta, Meli, Ridolfi and Rindi, Tribology International 69 (2014)
128, fitted to braking tests of a coach with wheel-slide protection at Velim). Friction is between that of the film and
that of the clean contact, as Voltr and Lata describe their measurements (Vehicle System Dynamics 53 (2015) 605). Where
the film is the better of both it stays. The energy lags by the transit 2 a/v of the contact, in which the film is
exposed to it.
</p>
<p>
With the heat of <a href=\"modelica://RailBraking.Contact.HeatedContact\">HeatedContact</a> adhesion has two maxima
over slip: that of the film, and one where cleaning and heat balance. Both can be switched off: removal_rate = 0,
temperature_loss = 0.
</p>
<h4>Limitations</h4>
<p>
Own contacts only: the energy that a wheel leaves for those behind it belongs to the rail, in a program that knows where
wheels are. The harness has both in its rail and uses HeatedContact. The film on the tread is part of removal_rate.
Creep stiffness stays that of the film. The share of the energy that removes the film is an estimate, and small: wear of
some 10 &micro;g/(N m) takes far less than the heat.
</p>
</html>"));
end CleaningContact;
