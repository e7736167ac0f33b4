within RailBraking.Contact.Surfaces;
record Dry "Clean dry rail"
  extends Icons.Record;
  extends Parameters(k_A=1.0, k_S=0.4, mu0=0.55, A=0.4, B=0.6);
  annotation (
    Documentation(info="<html>
<p>Polach (2005), typical parameters for dry conditions.</p>
</html>"));
end Dry;
