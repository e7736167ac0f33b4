within Features;
model Redeclared "Partial classes, replaceable models and functions, redeclared"
  partial function law
    input Real s;
    output Real y;
  end law;
  function soft
    extends law;
  algorithm
    y := tanh(s);
  end soft;
  function hard
    extends law;
  algorithm
    y := s*(1 + s^2);
  end hard;
  partial model Part
    input Real u;
    output Real y;
  end Part;
  model Gain
    extends Part;
    parameter Real k = 2;
  equation
    y = k*u;
  end Gain;
  model Square
    extends Part;
  equation
    y = u^2;
  end Square;
  model Holder
    replaceable Gain part constrainedby Part;
    replaceable function mu = soft constrainedby law;
    Real x(start=1, fixed=true);
  equation
    part.u = x;
    der(x) = -part.y - mu(x);
  end Holder;
  Holder a(redeclare Square part);
  Holder b(part(k=3), redeclare function mu = hard);
end Redeclared;
