within RailBraking.Data;
record CreepCurve "Shape of the creep curve of a wheelset, which may change along the track"
  extends Icons.Record;
  Types.Ratio k_A(min=0, max=1) = 0.3 "Polach: reduction of the creep stiffness in the area of adhesion";
  Types.Ratio k_S(min=0, max=1) = 0.1 "Polach: reduction of the creep stiffness in the area of slip, not above k_A";
  Types.Ratio A(min=0, max=1) = 0.4 "Polach: friction at infinite slip speed over maximum friction";
  Types.InverseVelocity B(min=0) = 0.2 "Polach: rate at which friction falls with slip speed";
  annotation (
    Documentation(info="<html>
<p>
Parameters of <a href=\"modelica://RailBraking.Contact.polach\">Contact.polach</a> besides the
friction. A vehicle has one curve for all of its wheelsets, defined by its parameters. For a rail
whose curve changes from place to place, bind
<code>curve</code> to inputs, as in
</p>
<blockquote><pre>
extends Plants.TwoPartTrain(
  curve={Data.CreepCurve(k_A=k_A_in[i], k_S=k_S_in[i], A=A_in[i], B=B_in[i]) for i in 1:6});
</pre></blockquote>
</html>"));
end CreepCurve;
