within RailBraking.Contact.Surfaces;
record Wet "Wet rail"
  extends Icons.Record;
  extends Parameters(k_A=0.3, k_S=0.1, mu0=0.30, A=0.4, B=0.2);
  annotation (
    Documentation(info="<html>
<p>Polach (2005), typical parameters for wet conditions.</p>
</html>"));
end Wet;
