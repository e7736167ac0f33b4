within Features;
model Sampled "Sampled controller: sample, pre, elsewhen, Integer counters"
  discrete Real u(start=0, fixed=true);
  Integer n(start=0, fixed=true);
  Integer seen(start=0, fixed=true);
  Boolean high;
  Real x(start=0, fixed=true);
equation
  when sample(0.05, 0.1) then
    u = 2*(1 - x);
    n = pre(n) + 1;
  end when;
  when x > 0.8 then
    seen = pre(seen) + 10;
  elsewhen x > 0.4 then
    seen = pre(seen) + 1;
  end when;
  high = x > 0.6;
  der(x) = u - (if high then 0.5 else 0.1)*x;
end Sampled;
