within RailBraking.UsersGuide;
class References "Literature"
  annotation (
    DocumentationClass=true,
    Documentation(info="<html>
<ul>
<li>Allotta, B., Meli, E., Ridolfi, A., Rindi, A.: Development of an innovative wheel-rail contact model for the
analysis of degraded adhesion in railway systems. Tribology International 69 (2014), 128-140.</li>
<li>Ehret, M.: Identification of a dynamic friction model for railway disc brakes. Proc. IMechE Part F (2021).</li>
<li>EN 15355: Distributor valves and distributor-isolating devices. CEN (2019).</li>
<li>Ertz, M.: Creep force laws for wheel/rail contact with temperature-dependent coefficient of friction (2002).</li>
<li>Ertz, M., Knothe, K.: A comparison of analytical and numerical methods for the calculation of temperatures in
wheel/rail contact. Wear 253 (2002), 498-508.</li>
<li>Greenwood, J. A.: Analysis of elliptical Hertzian contacts. Tribology International 30 (1997), 235-237.</li>
<li>ISO 6358: Pneumatic fluid power, determination of flow-rate characteristics.</li>
<li>Kalker, J. J.: A fast algorithm for the simplified theory of rolling contact. Vehicle System Dynamics 11 (1982),
1-13.</li>
<li>Kalker, J. J.: Three-dimensional Elastic Bodies in Rolling Contact. Kluwer (1990).</li>
<li>Mal, K., Hussain, I., Chowdhry, B. S., Memon, T. D.: Extended Kalman filter for estimation of contact forces at
wheel-rail interface. 3C Tecnolog&iacute;a, special issue (2020), 279-301.</li>
<li>Ostermeyer, G. P.: On the dynamics of the friction coefficient. Wear 254 (2003), 852-858.</li>
<li>Polach, O.: Creep forces in simulations of traction vehicles running on adhesion limit. Wear 258 (2005),
992-1000.</li>
<li>Pugi, L. et al.: A parametric library for the simulation of a UIC pneumatic braking system. Proc. IMechE Part F 218
(2004), 117-132.</li>
<li>Pugi, L. et al.: Railway Engineering Science 31 (2023), 108, on wheel-slide protection valves.</li>
<li>Schwarz, C., L&uuml;dicke, D., Heckmann, B.: Friction Estimation for Railway Brake Systems in Field Tests. Int.
Railway Symposium Aachen (2019), 608-623.</li>
<li>Schwarz, C., Keck, A.: Simultaneous Estimation of Wheel-Rail Adhesion and Brake Friction Behaviour.
IFAC-PapersOnLine 53 (2020), 8470-8475.</li>
<li>Schwarz, C., Posielek, T., Goetjes, B.: Adhesion-Based Maximum-Seeking Brake Control for Railway Vehicles
(2021).</li>
<li>Spiryagin, M., Polach, O., Cole, C.: Creep force modelling for rail traction vehicles based on the Fastsim
algorithm. Vehicle System Dynamics 51 (2013).</li>
<li>Tian, X., Kennedy, F. E.: Maximum and average flash temperatures in sliding contacts. Journal of Tribology 116
(1994), 167-174.</li>
<li>Voltr, P., Lata, M.: Transient wheel-rail adhesion characteristics under the cleaning effect of sliding. Vehicle
System Dynamics 53 (2015), 605-618.</li>
<li>UIC 540: Air brakes for freight trains and passenger trains. 5th edition (2006).</li>
</ul>
<p>
Vehicle data not found in these papers (brake rigging, suspension, discs) are engineering estimates; each default can
be changed.
</p>
</html>"));
end References;
