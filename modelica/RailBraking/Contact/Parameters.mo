within RailBraking.Contact;
record Parameters "Polach's description of a rail surface"
  extends Icons.Record;
  parameter Types.Ratio k_A(min=0, max=1) "Reduction of the creep stiffness in the area of adhesion";
  parameter Types.Ratio k_S(min=0, max=1) "Reduction of the creep stiffness in the area of slip, not above k_A";
  parameter Types.Ratio mu0(min=0, max=1) "Maximum friction coefficient, at zero slip speed";
  parameter Types.Ratio A(min=0, max=1) "Friction at infinite slip speed over maximum friction";
  parameter Types.InverseVelocity B(min=0) "Rate at which friction falls with slip speed";
  annotation (
    Documentation(info="<html>
<p>
k_A and k_S are those of Polach (2005): (k_A + k_S)/2 is the creep stiffness relative to that of a
clean, smooth contact by Kalker's theory. A plant takes <code>mu0</code> as an input instead, one
for each wheelset, because
that is what varies along the track.
</p>
</html>"));
end Parameters;
