within Features;
model FunctionLoops "for, while, early return, protected arrays, several results"
  function interpolate "Piecewise linear table"
    input Real x;
    input Real xs[:];
    input Real ys[size(xs, 1)];
    output Real y;
  algorithm
    y := ys[1];
    for i in 1:size(xs, 1) - 1 loop
      y := y + (ys[i + 1] - ys[i])*min(max((x - xs[i])/(xs[i + 1] - xs[i]), 0), 1);
    end for;
  end interpolate;
  function halved "x/8 the long way"
    input Real x;
    output Real y;
  protected
    Integer i;
  algorithm
    i := 0;
    y := x;
    while i < 3 loop
      y := 0.5*y;
      i := i + 1;
    end while;
  end halved;
  function clipped
    input Real x;
    input Real limit = 1;
    output Real y;
  algorithm
    y := 0;
    if x > limit then
      y := limit;
      return;
    end if;
    y := x;
  end clipped;
  function circle
    input Real phi;
    output Real s;
    output Real c;
  algorithm
    s := sin(phi);
    c := cos(phi);
  end circle;
  function normalised
    input Real x[:];
    output Real y[size(x, 1)];
  protected
    Real total;
  algorithm
    total := sum(x);
    for i in 1:size(x, 1) loop
      y[i] := x[i]/total;
    end for;
  end normalised;
  parameter Real xs[4] = {0, 1, 2, 4};
  parameter Real ys[4] = {0, 1, 0.5, 2};
  Real x(start=0.1, fixed=true);
  Real z[3](start={1, 2, 3}, each fixed=true);
  Real s;
  Real c;
  output Real y;
equation
  (s, c) = circle(x + time);
  der(x) = 0.3 + 0.2*clipped(s, limit=0.4) + halved(c);
  der(z) = -normalised(z);
  y = interpolate(x, xs, ys);
end FunctionLoops;
