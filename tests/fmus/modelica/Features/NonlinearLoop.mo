within Features;
model NonlinearLoop "A network of quadratic resistances: a nonlinear loop of two"
  model Valve
    parameter Real k = 1;
    Real q;
    Real p1;
    Real p2;
  equation
    p1 - p2 = k*q*abs(q) + 0.01*q;
  end Valve;
  Valve a;
  Valve b(k=2);
  Valve c(k=0.5);
  Real x(start=1, fixed=true);
  output Real q;
equation
  a.p1 = 2 + sin(time);
  a.p2 = b.p1;
  a.p2 = c.p1;
  a.q = b.q + c.q;
  b.p2 = 0;
  c.p2 = 0.1*x;
  der(x) = c.q - 0.2*x;
  q = a.q;
end NonlinearLoop;
