within Features;
model TimeEvents "Changes at known instants, one of them a parameter"
  parameter Real T = 0.35;
  Boolean late;
  Real x(start=0, fixed=true);
  Real y(start=1, fixed=true);
equation
  late = time >= 2*T;
  der(x) = if time < 0.25 then 1 elseif time < T then -2 else 0.5;
  der(y) = if late then -y else y;
end TimeEvents;
