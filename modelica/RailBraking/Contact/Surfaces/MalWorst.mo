within RailBraking.Contact.Surfaces;
record MalWorst "Worst adhesion of Mal and others"
  extends Icons.Record;
  extends Parameters(k_A=1.0, k_S=1.0, mu0=0.1, A=0.1, B=0.2);
  annotation (
    Documentation(info="<html>
<p>As MalDry, worst condition.</p>
</html>"));
end MalWorst;
