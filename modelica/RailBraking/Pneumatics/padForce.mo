within RailBraking.Pneumatics;
function padForce "Normal force of both pads of a brake unit together"
  extends Icons.Function;
  input Types.Pressure pressure "Pressure in the cylinder, above the atmosphere";
  input Types.Area A_piston "Area of the piston";
  input Types.Ratio i_rigging "Force of both pads over force of the piston";
  input Types.Ratio eta_rigging "Efficiency of the rigging";
  input Types.Force F_spring "Force of return spring and slack adjuster";
  output Types.Force pad_force "Normal force of both pads";
protected
  constant Types.Force F_small = 50 "Rounding of the start of the stroke";
algorithm
  pad_force := eta_rigging*i_rigging*positivePart(pressure*A_piston - F_spring, F_small);
  annotation (
    smoothOrder=100,
    Inline=true,
    Documentation(info="<html>
<h4>Syntax</h4>
<blockquote><pre>
pad_force = Pneumatics.<strong>padForce</strong>(pressure, A_piston, i_rigging, eta_rigging, F_spring);
</pre></blockquote>
<h4>Limitations</h4>
<p>
The rounding causes a pad force of 3 N for an empty cylinder with a spring of 1.2 kN, one part in twenty thousand of
full braking, and adds less than that under pressure.
</p>
</html>"));
end padForce;
