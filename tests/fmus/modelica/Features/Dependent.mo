within Features;
model Dependent "Parameters computed from parameters, start values from parameters"
  constant Real g = 9.81;
  parameter Real m = 2;
  parameter Real weight = m*g;
  parameter Real half = 0.5*weight;
  final parameter Real third = weight/3;
  parameter Integer n = 3;
  parameter Real k[n] = {i*half for i in 1:n};
  Real x[n](start=k/10, each fixed=true);
  Real y(start=third, fixed=true);
equation
  der(x) = -k .* x/20;
  der(y) = -y*m;
end Dependent;
