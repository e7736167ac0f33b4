within RailBraking.Contact;
block SimplifiedContact "The two contacts of one wheelset by Kalker's simplified theory"
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
  alpha = simplifiedTheory(slip, v - r*w, load_positive/2, mu0, factor, curve.k_A, curve.k_S, curve.A, curve.B);
  F = alpha*load_positive;
  heat_flow = F*(v - r*w);
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
<a href=\"modelica://RailBraking.Contact.WheelsetContact\">WheelsetContact</a> with
<a href=\"modelica://RailBraking.Contact.simplifiedTheory\">simplifiedTheory</a> in place of
Polach's force. Both have the same creep curve at very small and at large slip; between them this one is steeper and
saturates sooner.
</p>
<h4>Limitations</h4>
<p>Those of <a href=\"modelica://RailBraking.Contact.simplifiedTheory\">simplifiedTheory</a>.</p>
</html>"));
end SimplifiedContact;
