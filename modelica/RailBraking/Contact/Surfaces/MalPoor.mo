within RailBraking.Contact.Surfaces;
record MalPoor "Poor adhesion of Mal and others"
  extends Icons.Record;
  extends Parameters(k_A=1.0, k_S=1.0, mu0=0.2, A=0.1, B=0.2);
  annotation (
    Documentation(info="<html>
<p>As MalDry, poor condition.</p>
</html>"));
end MalPoor;
