package P
  constant Real k = 2;
  constant Integer size3 = 3;
  type Level = enumeration(low, middle, high);
  type Length = Real(final quantity="Length", final unit="m");
  type Distance = Length(min=0);
  type Speed = Real(final unit="m/s", displayUnit="km/h", start=7);
  type Fast = Speed(start=30);
  model A
    parameter Real q = 3;
    parameter Real v[2] = {1, 2};
    output Real y = q + sum(v);
  end A;
  model B
    extends A(q=5);
  end B;
  partial model Law
    parameter Real r = 1;
    output Real y;
  end Law;
  model Linear
    extends Law;
  equation
    y = 10*r;
  end Linear;
  model Square
    extends Law(r=3);
  equation
    y = r^2;
  end Square;
  model Holder
    parameter Real k = 7;
    replaceable Linear law(r=k) constrainedby Law(r=k);
  end Holder;
  model Chooser
    replaceable model L = Linear constrainedby Law;
    L law(r=4);
  end Chooser;
  record R
    parameter Real a = 1;
    parameter Real b = 2;
  end R;
  record R3
    extends R(b=20);
    parameter Real c = 3;
  end R3;
  connector Flange
    Real s;
    flow Real f;
  end Flange;
  connector In = input Real;
  connector Out = output Real;
  model Wall
    Flange c;
  equation
    c.s = 0;
  end Wall;
  model Spring
    parameter Real stiffness = 2;
    Flange a;
    Flange b;
  equation
    a.f = stiffness*(a.s - b.s);
    a.f + b.f = 0;
  end Spring;
  model Force
    parameter Real f = 6;
    Flange c;
  equation
    c.f = -f;
  end Force;
  block Gain
    parameter Real k = 2;
    In u;
    Out y;
  equation
    y = k*u;
  end Gain;
  block Source
    parameter Real k = 5;
    Out y;
  equation
    y = k;
  end Source;
  model World
    parameter Real g = 9;
    Real h = 2*g;
  end World;
  model Falling
    outer World world;
    Real y = world.g + world.h;
  end Falling;
  model Counter
    outer Integer n;
    outer Boolean on;
    outer parameter Real m;
    outer parameter Level level;
    outer Integer list[2];
    Real y = n + (if on then 1 else 0) + m + Integer(level) + list[2];
  end Counter;
  function scaled
    input Real u;
    input Real factor = k;
    output Real y = factor*u;
  algorithm
  end scaled;
// classes
end P;
model M
  Real x(start=0, fixed=true);
// components
equation
  der(x) = 1;
end M;
