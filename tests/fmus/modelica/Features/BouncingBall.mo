within Features;
model BouncingBall "reinit: a ball that keeps 0.7 of its speed"
  parameter Real e = 0.7;
  parameter Real g = 9.81;
  Real h(start=1, fixed=true);
  Real v(start=0, fixed=true);
  Integer bounces(start=0, fixed=true);
equation
  der(h) = v;
  der(v) = -g;
  when h < 0 then
    reinit(v, -e*pre(v));
    bounces = pre(bounces) + 1;
  end when;
end BouncingBall;
