within RailBraking.Contact;
block WheelsetContact "The two contacts of one wheelset"
  extends Icons.Contact;
  extends Interfaces.PartialContact;
  final parameter Real factor = creepFactor(r/(1 + r*curvature_rail), r_rail, E, nu)
    "Slope of epsilon, see creepFactor";
protected
  final parameter Types.Force F_small = 100 "Rounding of the load about zero";
  Types.Force load_positive "Load, rounded to stay positive if the wheelset is unloaded";
equation
  slip = (v - r*w)/sqrt(v^2 + v_small^2);
  load_positive = (load + sqrt(load^2 + F_small^2))/2;
  alpha = polach(slip, v - r*w, load_positive/2, mu0, factor, curve.k_A, curve.k_S, curve.A, curve.B);
  F = alpha*load_positive;
  heat_flow = F*(v - r*w);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Ellipse(extent={{-50, 70}, {50, -30}}, lineColor={0, 0, 127}),
        Line(points={{-80, -30}, {80, -30}}, color={0, 0, 127})}),
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
Slip is (v - r w)/sqrt(v<sup>2</sup> + v_small<sup>2</sup>), 0.5 % smaller than 1 - r w/v at 1 m/s
and zero at standstill. Valid from rest to 60 m/s. Both wheels carry half of the load and have equal
contacts.
</p>
<p>
On a roller the contact is that of a wheel of the radius 1/(1/r + <code>curvature_rail</code>) on a straight rail;
kinematics keep <code>r</code>.
</p>
<h4>Limitations</h4>
<p>
Below <code>v_small</code> a creeping wheel behaves like a very stiff damper; static friction is modelled by
<a href=\"modelica://RailBraking.Components.Wheelsets\">Wheelsets</a> and
<a href=\"modelica://RailBraking.Components.Rest\">Rest</a>. The rounding of the load adds
F_small<sup>2</sup>/(4 load), less than 0.03 N for any railway wheelset.
</p>
</html>"));
end WheelsetContact;
