within Features;
model Oscillator "A driven oscillator with a closed-form answer, for the order of the solvers"
  Real x(start=1, fixed=true);
  Real v(start=0, fixed=true);
equation
  der(x) = v;
  der(v) = -4*x + 3*cos(time);
  annotation (Documentation(info="<html><p>x = cos t, because −cos t + 4 cos t = 3 cos t.</p></html>"));
end Oscillator;
