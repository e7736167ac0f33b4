within Features;
block Driven "Everything at the edge: inputs of three types, outputs, bounds, units, assertions"
  parameter Real k(unit="1/s", min=0) = 2 "Rate";
  parameter Real limit(unit="m") = 100 "Largest x allowed";
  input Real u(start=1, unit="m/s", min=-10, max=10) "Push";
  input Boolean frozen(start=false) "= true, if nothing moves";
  input Integer gear(start=1) "Multiplies the push";
  output Real y(unit="m", nominal=5) "Position";
  output Real x(start=0.5, fixed=true, unit="m", nominal=5) "State and output at once";
  output Boolean beyond "= true, if x is more than 2 m";
  output Integer count(start=0, fixed=true) "How often that began";
equation
  der(x) = if frozen then 0 else gear*u - k*x*unit;
  y = 2*x + u*second;
  beyond = x > 2;
  when beyond then
    count = pre(count) + 1;
  end when;
  assert(x < limit, "x = " + String(x) + " is 100 % beyond its limit");
  assert(x > -1, "x is negative", AssertionLevel.warning);
protected
  constant Real unit = 1;
  constant Real second(unit="s") = 1;
end Driven;
