within Features;
model Matrices "Matrices, slices, comprehensions, reductions, concatenation"
  parameter Real A[2, 2] = [-0.1, 1; -1, -0.1];
  parameter Integer n = 4;
  Real z[2](start={1, 0}, each fixed=true);
  Real w[n](start={4, 3, 2, 1}/4, each fixed=true);
  Real total;
  Real big[2, 3];
  Real picked[2];
equation
  der(z) = A*z + cat(1, {total}, {0.1})/10;
  der(w) = {-w[i]*i/n for i in 1:n};
  total = sum(w[i]*i for i in 1:n)/n + max(w) + w*w;
  big = [transpose([z, 2*z]), {1, 2}];
  picked = big[1:2, 2] + identity(2)*w[{1, 3}] + fill(0.5, 2) + linspace(0, 1, 2);
end Matrices;
