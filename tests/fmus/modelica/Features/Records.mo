within Features;
model Records "Records of parameters, enumerations, Integer and Boolean parameters"
  type Shape = enumeration(Linear, Square, Cubic);
  record Data
    parameter Real a = 1;
    parameter Real b = 2;
  end Data;
  record Steep
    extends Data(a=3);
  end Steep;
  function force
    input Data d;
    input Real x;
    output Real y;
  algorithm
    y := d.a*x + d.b*x^3;
  end force;
  parameter Data d(b=0.5);
  parameter Steep e;
  parameter Shape shape = Shape.Square;
  parameter Integer k = 2;
  parameter Boolean damped = true;
  Real x(start=1, fixed=true);
  Real v(start=0, fixed=true);
equation
  der(x) = v;
  der(v) = -force(d, x) - e.a*x - (if damped then 0.2*v else 0)
    - (if shape == Shape.Linear then x elseif shape == Shape.Square then x^k else x^3);
end Records;
