within RailBraking.Contact.Surfaces;
record VeryLow "Rail with hardly any adhesion"
  extends Icons.Record;
  extends Parameters(k_A=0.3, k_S=0.1, mu0=0.03, A=0.4, B=0.1);
  annotation (
    Documentation(info="<html>
<p>The very low level of the authors named in LowAdhesion. Medium to low confidence.</p>
</html>"));
end VeryLow;
