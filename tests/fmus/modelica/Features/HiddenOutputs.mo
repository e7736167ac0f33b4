within Features;
model HiddenOutputs "Outputs in a protected part, one of which is a state"
  output Real y "Twice x";
protected
  output Real x(start=1, fixed=true) "State";
  output Real z "Its negative";
  output Boolean low "= true, below one half";
equation
  der(x) = -x;
  z = -x;
  low = x < 0.5;
  y = if low then 2*x else -2*z;
end HiddenOutputs;
