within ForeignTrain;
function magicFormula "Friction used at a given creep"
  input Real creep(final unit="1") "Relative creep, negative when braking";
  input Real grip(final unit="1") "Friction at the peak";
  input Real creep_peak(final unit="1") "Creep at the peak, positive";
  input Real shape(final unit="1") "Between 1, which never falls, and 2, which falls to zero";
  output Real used(final unit="1") "Friction used, with the sign of the creep";
protected
  constant Real quarter_turn(final unit="rad") = 1.5707963267948966 "Half of pi";
algorithm
  used := grip*sin(shape*atan(tan(quarter_turn/shape)*creep/creep_peak));
  annotation (
    smoothOrder=100,
    Inline=true,
    Documentation(info="<html>
<p>
The formula of Bakker, Nyborg and Pacejka (SAE 870421, 1987) without curvature, its stiffness chosen so that the
peak lies at <code>creep_peak</code>. At large creep <code>grip*sin(shape*pi/2)</code> is left.
</p>
<h4>Limitations</h4>
<p>The peak does not move with the speed or the load of the wheel, as it does on rails.</p>
</html>"));
end magicFormula;
