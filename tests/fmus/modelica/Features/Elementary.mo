within Features;
model Elementary "Every elementary function, smooth, noEvent, abs, sign, min, max"
  Real x(start=0.3, fixed=true);
  Real a;
  Real b;
  Real c;
equation
  der(x) = 0.4*cos(time);
  a = sin(x) + cos(x) + tan(x) + asin(x/2) + acos(x/2) + atan(x) + atan2(x, 2);
  b = sinh(x) + cosh(x) + tanh(x) + exp(-x) + log(1 + x) + log10(2 + x) + sqrt(1 + x) + (1 + x)^1.5 + x^3;
  c = abs(x - 0.5) + noEvent(if x > 0.6 then x - 0.6 else 0) + smooth(0, if x > 0.4 then x else 0.4)
    + min(x, 0.45) + max(x, 0.35) + homotopy(x, 0);
end Elementary;
