within RailBraking.Contact.Surfaces;
record LowAdhesionSteep "Contaminated rail with the stiffness of a dry one"
  extends Icons.Record;
  extends Parameters(k_A=1.0, k_S=0.4, mu0=0.06, A=0.4, B=0.2);
  annotation (
    Documentation(info="<html>
<p>As LowAdhesion, but with the reductions 1.0 and 0.4 of a dry rail, which other authors of the
same group use. The peak is at a much smaller slip.</p>
</html>"));
end LowAdhesionSteep;
