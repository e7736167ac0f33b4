within Features;
model Edges "edge, change, and a hysteresis with pre"
  Boolean on(start=true, fixed=true);
  Integer switched(start=0, fixed=true);
  Integer risen(start=0, fixed=true);
  Real x(start=0, fixed=true);
equation
  on = x < 0.2 or pre(on) and x < 0.8;
  der(x) = if on then 1 - x else -2*x;
  when change(on) then
    switched = pre(switched) + 1;
  end when;
  when edge(on) then
    risen = pre(risen) + 1;
  end when;
end Edges;
