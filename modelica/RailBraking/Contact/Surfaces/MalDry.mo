within RailBraking.Contact.Surfaces;
record MalDry "Dry rail of Mal and others"
  extends Icons.Record;
  extends Parameters(k_A=1.0, k_S=1.0, mu0=0.46, A=0.4, B=0.6);
  annotation (
    Documentation(info="<html>
<p>
Mal, Hussain, Chowdhry and Memon (2020), contact condition dry. k_A = k_S = 1 means no loss of
stiffness: peaks are at a very small slip.
</p>
</html>"));
end MalDry;
