within RailBraking.Contact.Surfaces;
record BroadSoap "Rail sprayed with soap, as in tests of wheel-slide protection"
  extends Parameters(k_A=0.05, k_S=0.02, mu0=0.10, A=0.4, B=0.15);
  annotation (
    Icon(
      coordinateSystem(extent={{-100, -100}, {100, 100}}),
      graphics={
        Rectangle(extent={{-100, 100}, {100, -100}}, lineColor={0, 0, 127}, fillColor={255, 255, 255},
        fillPattern=FillPattern.Solid),
        Text(extent={{-150, 150}, {150, 110}}, textString="%name", textColor={0, 0, 255})}),
    Documentation(info="<html>
<p>An engineering estimate of this library, not a measurement: the peak is broad and lies near 10 % slip at 80 km/h,
where slip controllers for sprayed rails are tuned.</p>
</html>"));
end BroadSoap;
