within RailBraking.Contact.Surfaces;
record BroadLeaf "Rail with a film of leaves"
  extends Icons.Record;
  extends Parameters(k_A=0.04, k_S=0.015, mu0=0.10, A=0.5, B=0.10);
  annotation (
    Documentation(info="<html>
<p>An engineering estimate of this library, not a measurement: the peak is broad, near 16 % slip at 80 km/h.</p>
</html>"));
end BroadLeaf;
