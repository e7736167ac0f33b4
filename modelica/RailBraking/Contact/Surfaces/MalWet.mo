within RailBraking.Contact.Surfaces;
record MalWet "Wet rail of Mal and others"
  extends Icons.Record;
  extends Parameters(k_A=1.0, k_S=1.0, mu0=0.3, A=0.4, B=0.2);
  annotation (
    Documentation(info="<html>
<p>As MalDry, wet condition.</p>
</html>"));
end MalWet;
