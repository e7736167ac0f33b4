within RailBraking.FMUs;
block SimplifiedContactPoint "ContactPoint by Kalker's simplified theory"
  extends ContactPoint(
    alpha=Contact.simplifiedTheory(slip, 0, load/2, mu, factor, k_A, k_S, 1, 0));
  annotation (
    Diagram(coordinateSystem(extent={{-120, -120}, {120, 120}})),
    Documentation(info="<html>
<p>
The adhesion of <a href=\"modelica://RailBraking.Contact.SimplifiedContact\">SimplifiedContact</a> on an even rail, for
programs that need the contact by itself.
</p>
<h4>Limitations</h4>
<p>Those of ContactPoint and of <a href=\"modelica://RailBraking.Contact.simplifiedTheory\">simplifiedTheory</a>.</p>
</html>"));
end SimplifiedContactPoint;
