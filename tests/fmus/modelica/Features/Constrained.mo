within Features;
model Constrained "Two masses on one rod: a state too many; der of an algebraic variable"
  Real x(start=1, fixed=true);
  Real v(start=0, fixed=true);
  Real x2;
  Real v2;
  Real F;
  Real energy;
  Real power;
equation
  der(x) = v;
  der(v) = F - x;
  x2 = 2*x;
  der(x2) = v2;
  2*der(v2) = 1 - F;
  energy = 0.5*x^2;
  power = der(energy);
end Constrained;
