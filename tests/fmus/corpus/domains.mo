// Classes with an undefined value: name, last time at which it is defined [s], text of the line, and the message.

// acos | 0.25 | y = acos | acos\(2\*x \+ 0.5\): .* from -1 to 1
model M
 Real x(start=0,fixed=true);
 Real y;
equation
 der(x) = 1;
 y = acos(2*x + 0.5);
end M;

// asin | 0.375 | y = asin | asin.* from -1 to 1
model M
 Real x(start=0,fixed=true);
 Real y;
equation
 der(x) = 1;
 y = asin(0.5 - 4*x);
end M;

// sqrt | 0.5 | y = | sqrt\(0.5 - x\): .* not be negative
model M
 Real x(start=0,fixed=true);
 Real y;
equation
 der(x) = 1;
 y = max(sqrt(0.5 - x), 0);
end M;

// log | 0.45 | y = | log.* must be positive
model M
 Real x(start=0,fixed=true);
 Real y;
equation
 der(x) = 1;
 y = log(0.45 - x);
end M;

// log10 | 0.45 | y = | log10.* must be positive
model M
 Real x(start=0,fixed=true);
 Real y;
equation
 der(x) = 1;
 y = log10(0.45 - x);
end M;

// power | 0.45 | y = | \(0.45 - x\)\^0.3: a negative base
model M
 Real x(start=0,fixed=true);
 Real y;
equation
 der(x) = 1;
 y = (0.45 - x)^0.3;
end M;

// division | 0.0 | y = | 1/x: the divisor must not be zero
model M
 Real x(start=0,fixed=true);
 Real y;
equation
 der(x) = 0;
 y = 1/x;
end M;

// negative power | 0.0 | y = | x\^\(-2\): .* base of zero
model M
 Real x(start=0,fixed=true);
 Real y;
equation
 der(x) = 0;
 y = x^(-2);
end M;

// atan2 | 0.0 | y = | atan2\(x, x\): .* must not be zero
model M
 Real x(start=0,fixed=true);
 Real y;
equation
 der(x) = 0;
 y = atan2(x, x);
end M;

// pole of tan | 0.0 | y = | odd multiple of pi/2
model M
 Real x(start=0,fixed=true);
 Real y;
equation
 der(x) = 0;
 y = tan(x + 1.5707963267948966);
end M;

// array | 0.5 | y = | not be negative
model M
 Real x(start=0,fixed=true);
 Real y[3];
equation
 der(x) = 1;
 y = sqrt({1, 0.5 - x, 2});
end M;

// comparison | 0.5 | b = | sqrt\(0.5 - x\): .* not be negative
model M
 Real x(start=0,fixed=true);
 Boolean b;
equation
 der(x) = 1;
 b = sqrt(0.5 - x) > 2;
end M;

// derivative | 1.2 | der(x) | not be negative
model M
 Real x(start=0,fixed=true);
equation
 der(x) = 1 + sqrt(0.5 - x);
end M;

// index | 0.6 | t[i]; | t\[i\]: subscript 1 must be from 1 to 3, but it is 4
model M
 Real x(start=0,fixed=true);
 parameter Real t[3] = {1, 2, 3};
 Integer i = 1 + integer(5*time);
equation
 der(x) = t[i];
end M;

// index of a matrix | 0.6 | t[1, i]; | t\[1, i\]: subscript 2 must be from 1 to 3, but it is 0
model M
 Real x(start=0,fixed=true);
 parameter Real t[2, 3] = {{1, 2, 3}, {4, 5, 6}};
 Integer i = 3 - integer(5*time);
equation
 der(x) = t[1, i];
end M;

// index in a comparison | 1.0 | t[i] > | t\[i\]: subscript 1
model M
 Real x(start=0,fixed=true);
 parameter Real t[2] = {1, 2};
 Real y;
 Integer i = 1 + integer(2*time);
equation
 der(x) = 1;
 y = noEvent(if t[i] > 0 then 1 else 2);
end M;

// discrete variable | 0.5 | d = sqrt | not be negative
model M
 Real x(start=0,fixed=true);
 discrete Real d(start=0,fixed=true);
equation
 der(x) = 1;
 when sample(0.1, 0.1) then
  d = sqrt(0.45 - x);
 end when;
end M;

// index at an event | 0.4 | t[k] | t\[k\]: subscript 1 must be from 1 to 3, but it is 4
model M
 Real x(start=0,fixed=true);
 parameter Real t[3] = {1, 2, 3};
 Integer k(start=0,fixed=true);
 discrete Real d(start=0,fixed=true);
equation
 der(x) = 1;
 when sample(0.1, 0.1) then
  k = pre(k) + 1;
  d = if t[k] > 2 then 1 else 0;
 end when;
end M;

// previous value | 0.3 | y = | sqrt\(pre\(d\)\): .* not be negative, but it is -1
model M
 Real x(start=0,fixed=true);
 Integer d(start=1,fixed=true);
 Real y;
equation
 der(x) = 1;
 when time > 0.3 then
  d = -1;
 end when;
 y = max(0, sqrt(pre(d)));
end M;

// previous value of a clocked variable | 0.3 | y = | sqrt\(pre\(d\)\): .* not be negative, but it is -1
model M
 Real x(start=0,fixed=true);
 discrete Real d(start=1,fixed=true);
 Real y;
equation
 der(x) = 1;
 when sample(0.3, 1) then
  d = -1;
 end when;
 y = max(0, sqrt(pre(d)));
end M;

// condition of when | 0.45 | when log | log
model M
 Real x(start=0,fixed=true);
 discrete Real d(start=0,fixed=true);
equation
 der(x) = 1;
 when log(0.45 - x) < -20 then
  d = x;
 end when;
end M;

// coefficient of a derivative | 0.0 | der(x) | solved for der\(x\)
model M
 Real x(start=0,fixed=true);
equation
 (x - 0)*der(x) = 1;
end M;

// initial equation | 0.0 | w = sqrt | sqrt\(z\): .* -1\.
model M
 Real x(start=0,fixed=true), z(start=-1,fixed=true), w;
equation
 der(x) = 1; der(z) = 1; der(w) = 1;
initial equation
 w = sqrt(z);
end M;

// initial equation of a previous value | 0.0 | w = sqrt | sqrt\(pre\(d\)\): .* -1\.
model M
 Real x(start=0,fixed=true), w;
 discrete Real d(start=-1,fixed=true);
equation
 der(x) = 1; der(w) = 1;
 when time > 0 then d = 4; end when;
initial equation
 w = sqrt(pre(d));
end M;
