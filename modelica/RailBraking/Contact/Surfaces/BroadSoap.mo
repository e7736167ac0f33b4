within RailBraking.Contact.Surfaces;
record BroadSoap "Rail sprayed with soap, as in tests of wheel-slide protection"
  extends Icons.Record;
  extends Parameters(k_A=0.05, k_S=0.02, mu0=0.10, A=0.4, B=0.15);
  annotation (
    Documentation(info="<html>
<p>An engineering estimate of this library, not a measurement: the peak is broad, near 10 % slip at
80 km/h, for which slip controllers on sprayed rails are tuned.</p>
</html>"));
end BroadSoap;
