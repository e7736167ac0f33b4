within Features;
model IfEquations "if-equations with a parameter, with a state, and relations inside for"
  parameter Boolean choose = true;
  Real x[3](start={1, 2, 3}, each fixed=true);
  Real y(start=0, fixed=true);
  Real a;
  Real b;
equation
  if choose then
    a = x[1];
    b = 1;
  else
    a = 2*x[1];
    b = a;
  end if;
  for i in 1:3 loop
    der(x[i]) = if x[i] > 0.5 then -1 else -x[i];
  end for;
  if x[1] + x[2] > 1 then
    der(y) = a*b;
  else
    der(y) = -1;
  end if;
end IfEquations;
