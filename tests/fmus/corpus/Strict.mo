package P
  partial model Law
    parameter Real r = 1;
    output Real y;
  end Law;
  model A
    extends Law(r=2);
    parameter Real q = 3;
    parameter Real v[2] = {1, 2};
    final parameter Real f = 4;
  protected
    parameter Real hidden = 6;
  equation
    y = r + q + f + hidden + sum(v);
  end A;
  model B
    extends Law;
    parameter Real q = 5;
  equation
    y = r - q;
  end B;
  model E
    extends A;
    parameter Real extra = 1;
  end E;
  model Other
    output Real y;
  equation
    y = 1;
  end Other;
  record R
    parameter Real a = 1;
    parameter Real b = 2;
  end R;
  model N
    parameter Real k = 7;
    A n(q=8);
    replaceable A a(r=k);
    replaceable A plain constrainedby Law;
    replaceable A both(r=k) constrainedby Law(r=k);
    replaceable model M = A constrainedby Law;
    replaceable model MR = A(r=k);
    final A fa;
    replaceable constant Real c = 1;
    A arr[2];
    R whole = R(3, 4);
    M m;
    MR mr;
  protected
    A pa;
    replaceable A pra;
  end N;
  model Kept
    parameter Real k = 7;
    replaceable A a constrainedby Law(r=k);
  end Kept;
  model Lost
    parameter Real k = 7;
    replaceable A a(r=k) constrainedby Law;
  end Lost;
