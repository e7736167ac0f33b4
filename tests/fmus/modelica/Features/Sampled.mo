within Features;
model Sampled "Sampled controller: sample, pre, elsewhen, Integer counters"
  discrete Real u(start=0, fixed=true);
  Integer n(start=0, fixed=true);
  Integer seen(start=0, fixed=true);
  Boolean high;
  discrete Real shifted[3](each start=0, each fixed=true) "The last three values of x + 1, also at the start";
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
  when sample(0, 0.02) then
    shifted = cat(1, {x + 1}, pre(shifted[1:2]));
  end when;
  high = x > 0.6;
  der(x) = u - (if high then 0.5 else 0.1)*x;
end Sampled;
