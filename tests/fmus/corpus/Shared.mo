  package Shared
    constant Real c = 1.5;
    type Gear = enumeration(low, middle, high);
    record Pair
      Real a;
      Real b;
    end Pair;
    record Nested
      Pair p;
      Real c;
    end Nested;
    function double
      input Real x;
      output Real y;
    algorithm
      y := 2*x;
    end double;
    function scaled
      input Real x;
      input Real k = 3;
      input Real d = 1;
      output Real y;
    algorithm
      y := k*x + d;
    end scaled;
    function polar
      input Real x;
      output Real r;
      output Real phi;
    algorithm
      r := sqrt(x^2 + 1);
      phi := atan2(1, x);
    end polar;
    function total
      input Real v[:];
      output Real y;
    algorithm
      y := 0;
      for i in 1:size(v, 1) loop
        y := y + i*v[i];
      end for;
    end total;
    function norm
      input Pair p;
      output Real y;
    algorithm
      y := sqrt(p.a^2 + p.b^2);
    end norm;
    function pair
      input Real x;
      output Pair p;
    algorithm
      p.a := x;
      p.b := x + 1;
    end pair;
    function powers
      input Real x;
      input Integer n;
      output Real y[n];
    algorithm
      y[1] := x;
      for i in 2:n loop
        y[i] := y[i - 1]*x;
      end for;
    end powers;
    function clip
      input Real x;
      output Real y;
    algorithm
      if x > 1 then
        y := 1;
      elseif x < -0.5 then
        y := -0.5;
      else
        y := x;
      end if;
    end clip;
    function early
      input Real x;
      output Real y;
    algorithm
      y := 5;
      if x > 1 then
        return;
      end if;
      y := x;
    end early;
    function halvings
      input Real x;
      output Real y;
    protected
      Integer n;
    algorithm
      y := x;
      n := 0;
      while n < 3 loop
        y := y/2;
        n := n + 1;
      end while;
    end halvings;
    function until
      input Real x;
      output Real y;
    algorithm
      y := 0;
      for i in 1:10 loop
        if i > 4 then
          break;
        end if;
        y := y + x;
      end for;
    end until;
    function factorial
      input Integer n;
      output Integer y;
    algorithm
      y := if n <= 1 then 1 else n*factorial(n - 1);
    end factorial;
    partial function law
      input Real x;
      output Real y;
    end law;
    function square
      extends law;
    algorithm
      y := x*x;
    end square;
    function twice = scaled(k=2, d=0);
  end Shared;
