// Classes M, or P.M of a package, that are refused; the comment has the message and the text of the line it names.

// initial\(\); initial()
model M
 Real x(start=1,fixed=true);
Real y = if initial() then 0 else x;
equation
 der(x) = -y;
end M;

// initial\(\) in a condition of a when clause; when
model M
discrete Real x(start=3, fixed=true); equation
when not initial() then x = 6; end when;
end M;

// delay; delay(x
model M
 Real x(start=1,fixed=true);
equation
 der(x) = -delay(x, 0.1);
end M;

// terminate; x < 0.2
model M
 Real x(start=1,fixed=true);
equation
 der(x) = -x;
 when x < 0.2 then
  terminate("done");
 end when;
end M;

// string; String s
model M
 Real x(start=1,fixed=true);
 parameter String s = "a";
equation
 der(x) = if s == "a" then -x else x;
end M;

// a clock \(chapter 16; Clock c
model M
 Real x(start=1,fixed=true);
 Clock c = Clock(1, 10);
 Real y;
equation
 when c then y = sample(x); end when;
 der(x) = -x;
end M;

// fixed=false; fixed=false
model M
 Real x(start=1,fixed=true);
 Real y;
 parameter Real k(fixed=false, start=1);
equation
 der(x) = -k*x;
 y = x;
initial equation
 k = 3;
end M;

// external function f is not supported; f(x)
package P function f input Real x; output Real y;
 external "C" y = sin(x); end f;
model M Real x(start=1,fixed=true); equation
 der(x) = -f(x); end M; end P;

// assert inside function; assert
package P function f input Real x; output Real y;
 algorithm
 assert(x > 0, "x");
 y := sqrt(x); end f; model M Real x(start=1,fixed=true); equation der(x) = -f(x); end M; end P;

// depends on T; sample
model M
 parameter Real T = 0.1;
 discrete Real u(start=0,fixed=true);
equation
 when sample(0, T) then
 u = pre(u) + 1;
 end when;
end M;

// two arrays of components; wheels[i].contact[1].slip
package P
 record Contact Real slip; end Contact;
 model Wheel Contact contact[2]; equation contact[1].slip = time; contact[2].slip = 2*time; end Wheel;
 model M Wheel wheels[2]; Real y[2]; Real x(start=1,fixed=true);
 equation
  der(x) = -x;
  for i in 1:2 loop
   y[i] = wheels[i].contact[1].slip;
  end for;
 end M; end P;

// wheels.contact; wheels.contact[1].slip
package P
 record Contact Real slip; end Contact;
 model Wheel Contact contact[2]; equation contact[1].slip = time; contact[2].slip = 2*time; end Wheel;
 model M Wheel wheels[2]; Real y[2]; Real x(start=1,fixed=true);
 equation
  der(x) = -x;
  y = wheels.contact[1].slip;
 end M; end P;

// the slice a.z; a.z[2]
package P model A Real z[2] = {1, 2}*time; end A; model M A a[2]; Real y[2];
Real x(start=1,fixed=true); equation der(x) = -x;
y = a.z[2];
end M; end P;

// the slice a.p; sum(a.p)
package P model A parameter Real p = 1; end A; model M A a[2, 3](each p=6);
Real x(start=1,fixed=true); equation
der(x) = sum(a.p);
end M; end P;

// the front end, fails on this class; der(k)
model M
 Real x(start=1,fixed=true);
 parameter Real k = 1;
equation
 der(x) = der(k);
end M;

// must be differentiated; x = u
model M
 Real x(start=1,fixed=true);
 input Real u;
 Real v;
equation
 x = u;
 der(x) = v;
end M;

// a when statement in an algorithm section(.|\n)*and 2 more; when
package P
 model Overwritten discrete Real a(start=0, fixed=true), b(start=0, fixed=true);
 algorithm
  when sample(0.1, 0.2) then a := 1; b := a; a := 2; end when;
 end Overwritten;
 model Guarded discrete Real v(start=-1, fixed=true); Integer c(start=1, fixed=true);
 algorithm
  when sample(0.1, 0.2) then if c <= 2 then v := time; end if; c := pre(c) + 1; end when;
 end Guarded;
 model Element discrete Real v[3](each start=-1, each fixed=true); Integer c(start=1, fixed=true);
 algorithm
  when sample(0.1, 0.2) then v := pre(v); if c <= 3 then v[c] := time; end if; c := pre(c) + 1; end when;
 end Element;
 model Branches Integer n(start=0, fixed=true), m(start=0, fixed=true); Real x(start=0, fixed=true);
 equation
  der(x) = 1;
 algorithm
  when {x > 0.2, x > 0.4} then n := n + 1; if n > 1 then m := m + n; else m := -1; end if; end when;
 end Branches;
 model Loop discrete Real v[3](each start=-1, each fixed=true);
 algorithm
  when
   sample(0.1, 0.2) then for i in 1:3 loop v[i] := i*time; end for; v[2] := v[1] + v[3]; end when;
 end Loop;
 model M Overwritten a; Guarded b; Element c; Branches d; Loop e; end M; end P;

// when statement in an algorithm.*\n.*:10: when equations in several branches; when
model M
 parameter Boolean p = true;
 Integer n(start=0,fixed=true), m(start=0,fixed=true);
algorithm
 when time > 0.5 then m := pre(m) + 1; end when;
equation
 if p then
  when sample(0.1, 0.1) then n = pre(n) + 1; end when;
 else
  when sample(0.1, 0.2) then n = pre(n) + 1; end when;
 end if;
end M;

// an if equation in a when equation; if time
model M
 Integer n(start=0,fixed=true);
equation
 when sample(0.1, 0.1) then
  if time > 0.55 then n = pre(n) + 1; else n = pre(n) + 10; end if;
 end when;
end M;

// a part of an array in a when equation .*\n(.|\n)*a part of an array(.|\n)*reinit of an element; [
model M
 Integer n[2](each start=0,each fixed=true), m[2](each start=0,each fixed=true);
 Real x[2](each start=0,each fixed=true);
equation
 der(x) = {1, 1};
 for i in 1:2 loop when sample(0.1*i, 0.1) then
  n[i] = pre(n[i]) + i;
 end when; end for;
 when time > 0.5 then
  m[1] = 2;
  reinit(x[1], 10);
 end when;
end M;

// a while loop whose number of repetitions; while
package P
function f
 input Real u; output Real y;
algorithm
 y := u; while abs(y) > 1 loop y := y/2; end while;
end f;
model M
 Real x(start=2.0,fixed=true);
 output Real y;
equation
 der(x) = -x;
 y = f(x);
end M;
end P;

// break; break
package P
function f
 input Real u; output Real y;
algorithm
 y := 0; for i in 1:5 loop if i > 3 then break; end if; y := y + i; end for;
end f;
model M
 Real x(start=2.0,fixed=true);
 output Real y;
equation
 der(x) = -x;
 y = f(x);
end M;
end P;

// return inside a loop; return
package P
function f
 input Real u; output Real y;
algorithm
 y := 0; for i in 1:5 loop y := y + i; if i > 3 then return; end if; end for;
end f;
model M
 Real x(start=2.0,fixed=true);
 output Real y;
equation
 der(x) = -x;
 y = f(x);
end M;
end P;

// write `for i in 1:size; for v
package P
function f
 input Real u; output Real y;
algorithm
 y := 0; for v in {1.0, 3.0, u} loop y := y + v; end for;
end f;
model M
 Real x(start=2.0,fixed=true);
 output Real y;
equation
 der(x) = -x;
 y = f(x);
end M;
end P;

// must be Integer numbers; for i
package P
function f
 input Real u; output Real y;
algorithm
 y := 0; for i in 0.5:1:2.5 loop y := y + i; end for;
end f;
model M
 Real x(start=2.0,fixed=true);
 output Real y;
equation
 der(x) = -x;
 y = f(x);
end M;
end P;

// the recursive function P.f; f(u - 1)
package P
function f
 input Real u; output Real y;
algorithm
 y := if u < 1 then 1 else u*f(u - 1);
end f;
model M
 Real x(start=2.0,fixed=true);
 output Real y;
equation
 der(x) = -x;
 y = f(x);
end M;
end P;

// an assert inside function f; assert
package P
function f
 input Real u; output Real y;
algorithm
 y := u; assert(u > 0, "negative");
end f;
model M
 Real x(start=2.0,fixed=true);
 output Real y;
equation
 der(x) = -x;
 y = f(x);
end M;
end P;

// an assert inside function f; assert
package P
function f
 input Real u; output Real y;
algorithm
 y := u; for i in 1:2 loop y := y + 1; if y > 2 then assert(u > 0, "negative"); end if; end for;
end f;
model M
 Real x(start=2.0,fixed=true);
 output Real y;
equation
 der(x) = -x;
 y = f(x);
end M;
end P;

// an assert inside function f; assert
package P
function f
 input Real u; output Real y;
algorithm
 y := u; for i in 1:2 loop for j in 1:2 loop assert(u > i, "low"); end for; end for;
end f;
model M
 Real x(start=2.0,fixed=true);
 output Real y;
equation
 der(x) = -x;
 y = f(x);
end M;
end P;

// not assigned in every case; function f
package P
function f
 input Real u; output Real y;
algorithm
 if u > 3 then y := 1; end if;
end f;
model M
 Real x(start=2.0,fixed=true);
 output Real y;
equation
 der(x) = -x;
 y = f(x);
end M;
end P;

// sizes of the arrays do not fit.*y := u \+ .1, 2.; y
package P
function f
 input Real u; output Real y;
algorithm
 y := u + {1, 2};
end f;
model M
 Real x(start=2.0,fixed=true);
 output Real y;
equation
 der(x) = -x;
 y = f(x);
end M;
end P;

// sqrt\(-1\): the argument must not be negative; sqrt
package P
function f
 input Real u; output Real y;
algorithm
 y := sqrt(-1);
end f;
model M
 Real x(start=2.0,fixed=true);
 output Real y;
equation
 der(x) = -x;
 y = f(x);
end M;
end P;

// the divisor must not be zero; u/0
package P
function f
 input Real u; output Real y;
algorithm
 y := u/0;
end f;
model M
 Real x(start=2.0,fixed=true);
 output Real y;
equation
 der(x) = -x;
 y = f(x);
end M;
end P;

// P.M: a while loop .* write a for loop with a fixed range; while abs
package P
function root
 input Real u;
 output Real y;
protected
 Real step = 1;
algorithm
 y := u;
 while abs(step) > 1e-9 loop
  step := (y^2 - u)/(2*y);
  y := y - step;
 end while;
end root;
model M
 Real s(start=1,fixed=true);
 output Real y = root(s + 1);
equation
 der(s) = -s;
end M;
end P;

// algorithm section;
model M
output Real y(start=2); algorithm if time > 1 then y := 1; end if;
end M;

// algorithm section; algorithm
model M
input Integer k; output Integer n; algorithm
if k > 1 then n := pre(n) + 1; end if;
end M;

// loop without a range; for i loop
model M
function f input Real v[:]; output Real y; algorithm y := 0; for i loop y := 10*y + v[i]; end for; end f;
output Real y = f({1, 2, 4});
end M;

// drops an assertion; assert
model M
Real y; equation if time > 1 then y = 1; assert(time < 5, "a"); else y = 2; end if;
end M;

// illegal: .;
model M
output Real y; algorithm y := 1; while y < 4*time loop y := y + 1; end while;
end M;

// algo;
model M
output Real y; algorithm y := 1; for i in 1:3 loop y := 2*y; if y > 3 then break; end if; end for;
end M;

// .;
model M
output Real x[3]; algorithm x[1] := 1; x[2] := x[1];
end M;

// .;
model M
output Real y; algorithm for i in 1:2 loop i := 3; y := i; end for;
end M;

// illegal: .;
model M
parameter Real p; output Real y; algorithm y := 0; p := 1; y := y + p;
end M;

// .;
model M
output Real x[2]; algorithm for r in 1.0:2.0 loop x[r] := r; end for;
end M;

// .;
model M
output Real x[2]; equation for r in {{1, 2}, {2, 3}} loop x[r[1]] = r[2]; end for;
end M;

// would be lost;
model M
model A parameter Real k; parameter Real l; end A; model B A a; end B; B b(a.k = 4, a.l = 3);
end M;

// number of initial equations is 1 \(Model.mo:2 \(y\)\).*without a fixed start 0 \(none\).*fixed = false for 1;
model M Real x(start=1, fixed=true);
 Real y(start=6, fixed=true) = 2*x;
equation der(x) = -x; end M;

// number of initial equations is 1 \(Model.mo:2 \(y\)\).*without a fixed start 2 \(x, z\).*fixed = true for 1;
model M Real x, z;
 Real y(start=6, fixed=true) = x + z;
equation der(x) = -x; der(z) = -z; end M;

// n has more than one initial value;
model M Integer n(start=2, fixed=true);
initial equation n = 3; equation when time > 1 then n = 4; end when; end M;

// Model.mo:2.*initial equation of b itself.*write pre\(b\);
model M Boolean b; Real x(start=1, fixed=true);
initial equation b = true; equation b = x > 0.5; der(x) = -1; end M;

// Model.mo:2: M: initial\(\) and sample\(\) are supported in when clauses only;
model M Real x(start=1, fixed=true); Real y;
equation der(x) = -x; y = if initial() then 5 else x; end M;

// a part of an array in a when equation; [
block M
 input Real slip[4];
 discrete output Real d[4](each start=0, each fixed=true);
equation
 when sample(0, 0.01) then
  d[1:2] = slip[1:2];
  d[3:4] = slip[3:4];
 end when;
end M;

// a part of an array in a when equation; y[
model M
 discrete Real y[2](each start=0, each fixed=true);
equation
 when time > 0.5 then
  y[1] = 1;
  y[2] = 2;
 elsewhen time > 0.2 then
  y[1] = 3;
  y[2] = 4;
 end when;
end M;

// change of an input .*`Integer copy = k.*change\(copy\); change(k)
block M
 input Integer k(start=0);
 output Integer n(start=0, fixed=true);
equation
 when
  change(k) then
  n = pre(n) + 1;
 end when;
end M;

// pre of an input; n = k - pre(k)
block M
 input Integer k(start=0);
 output Integer n(start=0, fixed=true);
equation
 when sample(0, 0.1) then
  n = k - pre(k);
 end when;
end M;

// an initial algorithm for x is not supported; initial algorithm
model M
 Real x(start=1);
initial algorithm
 x := 2;
equation
 der(x) = -x;
end M;

// enumeration an equation each; in E
model M
 type E = enumeration(one, two);
 Real x[E];
equation
 for e in E loop
  x[e] = Integer(e)*time;
 end for;
end M;

// enumeration an equation each; E.one:E.two
package P type E = enumeration(one, two); model M
 Real x[E];
equation
 for e in E.one:E.two loop
  x[e] = Integer(e)*time;
 end for;
end M; end P;

// an iterator over an enumeration; sum(
package P type E = enumeration(one, two); model M
 parameter Real k[E] = {1, 2};
 Real y =
  sum(k[e] for e in E);
end M; end P;

// dimension expression could not be evaluated; Boolean
model M
 Real x[Boolean] = {1, 2}*time;
 output Real y = x[true];
end M;

// does not support this form; Clock
model M
 Real x(start=1, fixed=true);
 discrete Real y;
equation
 der(x) = -x;
 when Clock(0.1) then y = sample(x); end when;
end M;

// braked decides equations or sizes.*take its default (.|\n)*c.braked; if braked
package P
 model Car parameter Boolean braked = true; Real f;
 equation
  if braked then f = time; else f = 0; end if;
 end Car;
 model Train parameter Boolean b[2]; Car car[2](braked = b); end Train;
 model M
  Train train(b = {false, true});
  parameter Integer n[2] = {1, 2};
  Car car[2](braked = {n[i] > 1 for i in 1:2});
  Car c(braked = max(n) > 2);
 end M;
end P;

// c.n decides equations or sizes; n
package P
 model Car
  parameter Integer n = 1; Real z[n];
 equation
  for i in 1:n loop z[i] = time; end for;
 end Car;
 model M parameter Integer k[2] = {2, 1}; Car c(n = k[1]); end M;
end P;

// 2 equations for 4 unknowns .*miscounted.*computed from an array;
package P
 constant Integer k[2] = {0, 1};
 model Car
  parameter Integer n = 1;
  Real z[n];
  Real y;
 equation
  z = fill(time, n);
  for i in 1:n loop y = time; end for;
 end Car;
 model M Car c(n = k[2] + 1); Real x; end M;
end P;

// the condition of the component b has no value at build time;
package P connector C Real e; flow Real f; end C; model B C c; equation c.f = 1; end B;
 model D C c; equation c.e = time*c.f; end D;
 model Car parameter Boolean braked = true; D d;
  B b if braked;
 equation
  connect(b.c, d.c); end Car;
 model M parameter Boolean k[2] = {false, true}; Car c(braked = k[1]); end M; end P;

// the index of the class is 3: .* cannot be solved for y, vy at the start; x^2
model M
 Real x(start=1, fixed=true), y(start=0), vx(start=0, fixed=true), vy, f;
equation
 der(x) = vx; der(y) = vy; der(vx) = -f*x; der(vy) = -f*y - 9.81;
 x^2 + y^2 = 1;
end M;

// the index of the class is 3: .* does not say which variables are the states; x^2
model M
 parameter Real L = 1;
 Real x(start=0.8*L), y(start=-0.6*L), vx, vy, f;
equation
 der(x) = vx; der(y) = vy; der(vx) = -f*x; der(vy) = -f*y - 9.81;
 x^2 + y^2 = L^2;
end M;

// external function f is not supported; f(x)
package P function f input Real x; output Real y;
 external "FORTRAN 77" y = sin(x); end f;
model M Real x(start=1,fixed=true); equation
 der(x) = -f(x); end M; end P;

// this algorithm section; if time
package P function f input Real u; output Real y;
algorithm
 y := u; end f;
model M output Real y(start=2);
algorithm if time > 1 then y := f(time); end if;
end M; end P;

// algorithm section; y := 0
package P model A output Real y; parameter Integer n = 2;
algorithm y := 0; for i in 1:n loop y := y + i; end for; end A;
model M A a(n = 3); end M; end P;

// algorithm section; if time
package P model A output Real y;
algorithm if time > 1 then y := 1; end if; end A;
model M A a(y(start = 3)); end M; end P;

// 1/0: the divisor must not be zero; 1/0
model M Real x(start=0,fixed=true), y;
equation der(x) = 1;
 y = 1/0; end M;

// t\[n \+ 1\]: subscript 1 must be from 1 to 3, but it is 4; t[n + 1]
model M constant Integer n = 3; parameter Real t[3] = {1, 2, 3};
 Real x(start=0,fixed=true), y;
equation der(x) = 1;
 y = t[n + 1]; end M;

// the class has 1 equations;
model M Real x; Real y; equation x = 1; end M;
