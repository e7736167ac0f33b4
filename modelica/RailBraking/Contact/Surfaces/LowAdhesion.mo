within RailBraking.Contact.Surfaces;
record LowAdhesion "Contaminated rail with the shape of a wet one"
  extends Icons.Record;
  extends Parameters(k_A=0.3, k_S=0.1, mu0=0.06, A=0.4, B=0.2);
  annotation (
    Documentation(info="<html>
<p>The shape of Wet with lower friction, as the group of Pearson, Charles, Ward and Hussain uses it
for low adhesion. The values are repeated from paper to paper without a measurement: medium to low
confidence.</p>
</html>"));
end LowAdhesion;
