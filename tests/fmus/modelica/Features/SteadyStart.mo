within Features;
model SteadyStart "Initial equations, among them a nonlinear steady state"
  parameter Real load = 3;
  Real x(start=1);
  Real y(start=1, fixed=true);
  Real z;
equation
  der(x) = load - x*abs(x) - y;
  der(y) = x - y;
  der(z) = -z;
initial equation
  der(x) = 0;
  z = 2*y;
end SteadyStart;
