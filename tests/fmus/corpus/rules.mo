// Chapter 3 of the Modelica Language Specification, 3.6: operators and expressions, mostly those that make events.

// 3.3 the condition of an if expression decides which branch is evaluated; y = math.sqrt(max(t - 0.5, 0))
model M Real x = time - 0.5; Real y = noEvent(if x > 0 then sqrt(x) else 0); end M;

// 3.5 relations of Integers; y = 1 if 3 <= 10 * t < 4 else 3 if 4 <= 10 * t < 5 else 2
model M Integer n = integer(10*time); Real y = if n == 3 then 1 elseif n <> 4 then 2 else 3; end M;

// refused: 3.5 relations of Strings; y = 1
model M parameter String s = "b"; Real y = if s == "b" then 1 else 2; end M;

// 3.6.1 not, and, or of Booleans over time; y = 1 if 0.25 < t <= 0.5 or t > 0.75 else 0
model M Boolean a = time > 0.25; Boolean b = time > 0.5; Boolean c = a and not b or time > 0.75;
Real y = if c then 1 else 0; end M;

// 3.6.5 a Boolean if expression; y = 1 if t > 0.75 or 0.25 < t <= 0.5 else 0
model M Boolean a = if time > 0.5 then time > 0.75 else time > 0.25; Real y = if a then 1 else 0; end M;

// 3.7.1 the number of an enumeration literal; y = 2
model M parameter Shared.Gear g = Shared.Gear.middle; Real y = Integer(g); end M;

// refused: 3.7.2 floor of time jumps at whole multiples; y = math.floor(4 * t); n = math.floor(4 * t)
model M Real y = floor(4*time); Integer n(start=0, fixed=true); equation
when change(y) then n = pre(n) + 1; end when; end M;

// 3.7.2 mod of time as a saw tooth; y = t - 0.3 * math.floor(t / 0.3)
model M Real y = mod(time, 0.3); end M;

// 3.7.2 a pulse of mod; y = 1 if t - 0.3 * math.floor(t / 0.3) < 0.1 else 0; x = 0.1 * math.floor(t / 0.3) + min(0.1, t - 0.3 * math.floor(t / 0.3))
model M Boolean on = mod(time, 0.3) < 0.1; Real y = if on then 1 else 0; Real x(start=0, fixed=true);
equation der(x) = y; end M;

// 3.7.2 div and rem of Integers; y = 100 * (math.floor(10 * t) // 3) + 10 * (math.floor(10 * t) % 3) + (math.floor(10 * t) - 5) % 3
model M Integer n = integer(10*time); Integer d = div(n, 3); Integer r = rem(n, 3); Integer m = mod(n - 5, 3);
Real y = 100*d + 10*r + m; end M;

// 3.7.2 mod in a function next to div in the class; y = math.floor(10 * t) // 3; z = t % 0.4
function own input Real x; output Real y; algorithm y := mod(x, 0.4); end own;
model M Integer n = integer(10*time); Integer y = div(n, 3); Real z = own(time); end M;

// 3.7.2 integer of a state counts revolutions; y = math.floor(3.3 * t)
model M Real s(start=0, fixed=true); Integer i = integer(s); Real y = i; equation der(s) = 3.3; end M;

// 3.7.2 floor of a falling state; y = math.floor(1.6 - 3.3 * t)
model M Real s(start=1.6, fixed=true); Real y = floor(s); equation der(s) = -3.3; end M;

// 3.7.3 sign of a state; y = 1 if t > 0.5 else -1
model M Real s(start=-0.5, fixed=true); Real y = sign(s); equation der(s) = 1; end M;

// 3.7.4 der of an array; y = 1 + t + 10 * (2 - 2 * t)
model M Real x[2](start={1, 2}, each fixed=true); Real y = x[1] + 10*x[2]; equation der(x) = {1, -2}; end M;

// refused: 3.7.4 der of a product of states; y = 2 - t - (1 + t)
model M Real a(start=1, fixed=true); Real b(start=2, fixed=true); Real y = der(a*b); equation der(a) = 1;
der(b) = -1; end M;

// refused: 3.7.4 der of a parameter is zero; y = 1
model M parameter Real p = 3; Real y = der(p) + 1; end M;

// 3.7.4 second derivative; y = -4 * math.sin(2 * t)
model M Real x = sin(2*time); Real v = der(x); Real y = der(v); end M;

// refused: 3.7.4 delay; y = max(t - 0.2, 0)
model M Real y = delay(time, 0.2); end M;

// refused: 3.7.4 cardinality; y = 1
connector C Real e; flow Real f; end C; model M C a; C b; Real y = cardinality(a); equation connect(a, b);
a.e = 1; end M;

// 3.7.4 semiLinear with different slopes; y = (2 * t - 1) * (1 + t if t >= 0.5 else 5)
model M Real x = 2*time - 1; Real y = semiLinear(x, 1 + time, 5); end M;

// 3.7.4 homotopy has its actual value; y = 2
model M Real y(start=1); equation homotopy(actual=y^3, simplified=y) = 8; end M;

// 3.7.5 initial is true during initialization only; y = 2 * t
model M Real y(start=0, fixed=true); Integer n(start=5); equation der(y) = n;
when initial() then n = 2; end when; end M;

// refused: 3.7.5 initial in an if expression; x = 1
model M Real y = if initial() then 1 else 0; Real x(start=1, fixed=true); equation der(x) = y; end M;

// refused: 3.7.5 terminal is false while the simulation runs; y = 0
model M Real y = if terminal() then 1 else 0; end M;

// 3.7.5 noEvent with a relation that holds from the start; y = 2
model M Real y = noEvent(if time >= 0 then 2 else 1); end M;

// 3.7.5 sample counts from its start; y = 0 if t < 0.25 else 1 + math.floor((t - 0.25) / 0.2 + 1e-09)
model M Integer y(start=0, fixed=true); equation when sample(0.25, 0.2) then y = pre(y) + 1; end when; end M;

// 3.7.5 sample at the start of the simulation; y = 1 + math.floor(t / 0.3 + 1e-09)
model M Integer y(start=0, fixed=true); equation when sample(0, 0.3) then y = pre(y) + 1; end when; end M;

// 3.7.5 two clocks that coincide; y = 10 * math.floor(10 * t + 1e-09) + sum((2 * k - 1 for k in range(1, math.floor(5 * t + 1e-09) + 1)))
model M Integer a(start=0, fixed=true); Integer b(start=0, fixed=true); Real y = 10*a + b; equation
when sample(0.1, 0.1) then a = pre(a) + 1; end when; when sample(0.2, 0.2) then b = pre(b) + pre(a); end when; end M;

// 3.7.5 sample as a Boolean; y = 0 if t < 0.15 else 1 + math.floor((t - 0.15) / 0.3 + 1e-09)
model M Boolean s = sample(0.15, 0.3); Integer y(start=0, fixed=true); equation
when s then y = pre(y) + 1; end when; end M;

// 3.7.5 pre is the value before the event; y = 7 if t < 0.2 else 2 ** (math.floor(5 * t + 1e-09) - 1); a = 2 ** math.floor(5 * t + 1e-09)
model M discrete Real a(start=1, fixed=true); discrete Real y(start=7, fixed=true); equation
when sample(0.2, 0.2) then a = 2*pre(a); y = pre(a); end when; end M;

// 3.7.5 edge of a Boolean; y = 0 if t < math.asin(0.5) / 20 else 1 + math.floor((t - math.asin(0.5) / 20) * 20 / (2 * math.pi))
model M Boolean b = sin(20*time) > 0.5; Integer y(start=0, fixed=true); equation
when edge(b) then y = pre(y) + 1; end when; end M;

// 3.7.5 change of a Boolean; y = math.floor(20 * t / math.pi + 0.5)
model M Boolean b = cos(20*time) > 0; Integer y(start=0, fixed=true); equation
when change(b) then y = pre(y) + 1; end when; end M;

// 3.7.5 change of an Integer; y = sum(range(math.floor(5 * t + 1e-12) + 1))
model M Integer k = integer(5*time); Integer y(start=0, fixed=true); equation
when change(k) then y = pre(y) + k; end when; end M;

// 3.7.5 edge of not; y = 0 if t < 0.4 else 1
model M Boolean b = time < 0.4; Integer y(start=0, fixed=true); equation
when not b then y = pre(y) + 1; end when; end M;

// 3.7.5 reinit of one state of two; y = 2 * t if t < 0.4 else -1 + 2 * (t - 0.4); x = 1*t
model M Real x(start=0, fixed=true); Real y(start=0, fixed=true); equation der(x) = 1; der(y) = 2;
when x > 0.4 then reinit(y, -1); end when; end M;

// 3.7.5 reinit with the value before; x = math.exp(-t) if t < 0.5 else (2 * math.exp(-0.5) + 1) * math.exp(0.5 - t)
model M Real x(start=1, fixed=true); equation der(x) = -x; when time >= 0.5 then reinit(x, 2*pre(x) + 1);
end when; end M;

// 3.7.5 smooth and its events; y = max(t - 0.5, 0) ** 2
model M Real s(start=-0.5, fixed=true); Real y = smooth(1, if s > 0 then s^2 else 0); equation der(s) = 1; end M;

// 3.8.2 an Integer parameter in Real arithmetic; y = 1.5 + t
model M parameter Integer n = 3; parameter Integer m = 2; Real y = n/m + time; end M;

// 3.8.4 a discrete-time expression of a continuous one; y = 4 if t < 0.5 else 3
model M Real x = 2*time; Boolean b = x > 1; Integer k = if b then 3 else 4; Real y = k; end M;

// 3.7.2 mod of a negative argument in a function; y = (t - 0.5) % 0.4 + 10 * math.fmod(t - 0.5, 0.4)
function own input Real x; output Real y; algorithm y := mod(x - 0.5, 0.4) + 10*rem(x - 0.5, 0.4); end own;
model M Real y = own(time); end M;

// 3.7.5 not sample becomes true in the next iteration; y = math.floor((t - 0.05) / 0.1 + 1e-09) + 1
model M Boolean s = sample(0.05, 0.1); Integer y(start=0, fixed=true); equation
when not s then y = pre(y) + 1; end when; end M;

// 3.7.5 sample is true in one iteration only; y = 0
model M Boolean s = sample(0.05, 0.1); Boolean z(start=false, fixed=true); Real y = if z then 1 else 0; equation
when s then z = true; elsewhen not s then z = false; end when; end M;

// Chapter 4 of the Modelica Language Specification, 3.6: classes, predefined types and declarations.

// 4.4 the order of declarations does not matter; y = 9
model M Real y = a + b; parameter Real b = 2*a; parameter Real a = 3; end M;

// 4.4.2 a declaration of several variables with one type; y = 5 + 4 * t
model M Real a(start=1, fixed=true), b[2](each start=2, each fixed=true), y; equation der(a) = 1;
der(b) = {1, 2}; y = a + b[1] + b[2]; end M;

// 4.4.2 dimensions at the type and at the name; y = 6 * t + 320
model M Real[3] a[2]; Real y = a[2, 3] + 10*size(a, 1) + 100*size(a, 2); equation
a = [1, 2, 3; 4, 5, 6]*time; end M;

// 4.4.4 parameters that depend on others; y = 6*t
model M parameter Real a = 2; parameter Real b = a^2; final parameter Real c = a + b; Real y = c*time; end M;

// 4.4.4 a constant with a structural use; y = 6*t
model M constant Integer n = 3; Real x[n] = {i*time for i in 1:n}; Real y = sum(x); end M;

// 4.4.4 a parameter as the size of an array; y = 3 + 6 * t
model A parameter Integer n = 2; Real x[n](each start=1, each fixed=true); Real y = sum(x); equation
for i in 1:n loop der(x[i]) = i; end for; end A; model M A a(n=3); Real y = a.y; end M;

// 4.4.4 a size from the binding; y = 3 + 4 * t
model M parameter Real v[:] = {1, 2, 4}; Real y = size(v, 1) + v[3]*time; end M;

// 4.4.4 a size from a modifier; y = 19
model A parameter Real v[:]; Real y = size(v, 1) + sum(v); end A; model M A a(v={1, 2, 4, 8}); Real y = a.y; end M;

// 4.4.4 a discrete Real keeps its value; y = 3 if t < 0.5 else 0.5
model M discrete Real y(start=3, fixed=true); equation when time > 0.5 then y = time; end when; end M;

// 4.4.4 Integer and Boolean variables with equations; y = 2 if t < 0.3 else -2
model M Integer k = if b then 1 else -1; Boolean b = time < 0.3; Real y = 2*k; end M;

// 4.4.5 a conditional component that is absent; y = 1*t
model A Real z = 1; end A; model M parameter Boolean has = false; A a if has; A b if not has; Real y = time; end M;

// 4.4.5 connections to an absent component vanish; y = 6
connector C Real e; flow Real f; end C; model R C p; equation p.e = 2*p.f; end R;
model S C p; equation p.f = -3; end S;
model M S s; R r1; R r2 if false; Real y = r1.p.e; equation connect(s.p, r1.p); connect(s.p, r2.p); end M;

// 4.4.5 connections to a present component; y = 3
connector C Real e; flow Real f; end C; model R C p; equation p.e = 2*p.f; end R;
model S C p; equation p.f = -3; end S;
model M S s; R r1; R r2 if true; Real y = r1.p.e; equation connect(s.p, r1.p); connect(s.p, r2.p); end M;

// 4.5 a short class with modifiers; y = 4*t
model A parameter Real k = 1; Real y = k*time; end A; model B = A(k=4); model M B b; Real y = b.y; end M;

// 4.5.1 a type with an attribute and its derived types; y = 2 + t
type Length = Real(unit="m", min=0); type Height = Length(max=10); model M Height h(start=2, fixed=true);
Real y = h; equation der(h) = 1; end M;

// 4.5.1 a type that is an array; y = 3 * t + 4
type Point = Real[3]; model M Point p = {time, 2*time, 1}; Real y = sum(p) + size(p, 1); end M;

// 4.5.1 an array of an array type; y = 6 * t + 320
type Point = Real[3]; model M Point p[2]; Real y = p[2, 3] + 10*size(p, 1) + 100*size(p, 2); equation
p = [1, 2, 3; 4, 5, 6]*time; end M;

// 4.5.3 a local class; y = 2*t
model M model A Real z = 2*time; end A; A a; Real y = a.z; end M;

// 4.6 a block with inputs and outputs; y = 3*t
block B input Real u; output Real v; equation v = 3*u; end B; model M B b(u=time); Real y = b.v; end M;

// 4.6 a record with a binding for each field; y = t + 1
record R Real a = 1; Real b = a + 1; end R; model M R r(a=time); Real y = r.b; end M;

// 4.6 records in records; y = t + 320
model M Shared.Nested n = Shared.Nested(Shared.Pair(time, 2), 3); Real y = n.p.a + 10*n.p.b + 100*n.c; end M;

// 4.6 arrays of records; y = t + 10 * (2 + t) + 3 * t
model M Shared.Pair p[2]; Real y = p[1].a + 10*p[2].b + sum(p.a); equation for i in 1:2 loop
p[i].a = i*time; p[i].b = i + time; end for; end M;

// 4.6 equations between records; y = 3*t
model M Shared.Pair p; Shared.Pair q; Real y = q.a + q.b; equation p.a = time; p.b = 2*time; q = p; end M;

// 4.6 a record of parameters; y = 6
record R parameter Real a = 1; parameter Real b = 2; end R; model M parameter R r(b=5); R s = r;
Real y = r.a + s.b; end M;

// 4.6 a record that extends another; y = t + 1
record A Real a; end A; record B extends A; Real b; end B; model M B r; Real y = r.a + r.b; equation
r.a = time; r.b = 1; end M;

// 4.8 balanced: a partial model completed by its heir; y = 2*t
partial model A Real x; Real y; equation y = 2*x; end A; model M extends A; equation x = time; end M;

// 4.9.1 a start value that is only a guess; y = 4
model M Real y(start=3); equation y^2 = 16; end M;

// 4.9.1 a guess selects the other root; y = -4
model M Real y(start=-3); equation y^2 = 16; end M;

// 4.9.5 an enumeration as a parameter; y = 1
type E = enumeration(a "first", b, c); model M parameter E e = E.c; Real y = if e == E.c then 1
elseif e > E.a then 2 else 3; end M;

// 4.9.5 an enumeration that changes; y = 0 if t < 0.5 else 1
model M Shared.Gear g = if time < 0.5 then Shared.Gear.low else Shared.Gear.high;
Real y = if g == Shared.Gear.high then 1 else 0; end M;

// 4.9.5 an enumeration as an index; y = 2*t
model M Real v[Shared.Gear] = {1, 2*time, 3}; Real y = v[Shared.Gear.middle]; end M;

// refused: 4.9.5 a loop over an enumeration; y = 3*t
model M Real v[Shared.Gear]; Real y = v[Shared.Gear.high]; equation for g in Shared.Gear loop
v[g] = Integer(g)*time; end for; end M;

// refused: 4.9.5 a Boolean as an index; y = 2 * t + 10
model M Real v[Boolean] = {1, 2*time}; Real y = v[true] + 10*v[false]; end M;

// 4.9.6 stateSelect decides which state is kept; y = 2 + 2 * t
model M Real a(start=1, fixed=true, stateSelect=StateSelect.prefer); Real b; Real y = b; equation der(a) = 1;
b = 2*a; end M;

// 4.9 String parameters that nothing uses; y = 1*t
model M parameter String file = "none"; Real y = time; end M;

// Chapters 5 and 13 of the Modelica Language Specification, 3.6: names, inner and outer, packages and imports.

// 5.3.1 a name is found in the innermost class that has it; y = 3*t
constant Real k = 2; model M constant Real k = 3; model A Real z = k*time; end A; A a; Real y = a.z; end M;

// 5.3.1 an iterator hides a variable; y = 6 * t + 100
model M Real i = 100; Real y = sum(i*time for i in 1:3) + i; end M;

// 5.3.1 encapsulated classes see only what they import; y = 1.5*t
constant Real k = 2; encapsulated model A import Corpus.Shared; Real z = Shared.c*time; end A;
model M A a; Real y = a.z; end M;

// 5.3.2 composite names through packages; y = 4 * t + 4
package P package Q constant Real k = 4; model A Real z = k*time; end A; end Q; end P;
model M P.Q.A a; Real y = a.z + P.Q.k; end M;

// 5.3.2 a constant of an inherited package; y = 4*t
package P constant Real k = 4; end P; package Q extends P; end Q; model M Real y = Q.k*time; end M;

// refused: 5.3.2 a constant of a package that is modified in its heir; y = 5 * t + 4
package P constant Real k = 4; end P; package Q extends P(k=5); end Q; model M Real y = Q.k*time + P.k; end M;

// 5.3.2 a constant of a renamed package; y = 6*t
package P constant Real k = 4; end P; package Q = P(k=6); model M Real y = Q.k*time; end M;

// refused: 5.3.3 a name with a leading dot; y = 1.5*t
package Corpus constant Real c = 9; end Corpus; model M Real y = .Corpus.Shared.c*time; end M;

// refused: 5.4 inner and outer of a Real; y = 2*t
model A outer Real g; Real z = 2*g; end A; model M inner Real g = time; A a; Real y = a.z; end M;

// 5.4 inner and outer of a parameter; y = 7*t
model A outer parameter Real g; Real z = g*time; end A; model B inner parameter Real g = 1; A a; end B;
model M B b(g=7); Real y = b.a.z; end M;

// 5.4 inner and outer of an Integer; y = 2 * t if t < 0.5 else 3 * t
model A outer Integer n; Real z = n*time; end A; model M inner Integer n = if time < 0.5 then 2 else 3; A a;
Real y = a.z; end M;

// 5.4 inner and outer of a Boolean; y = 0 if t < 0.5 else 1
model A outer Boolean on; Real z = if on then 1 else 0; end A; model M inner Boolean on = time > 0.5; A a;
Real y = a.z; end M;

// 5.4 inner and outer of a component; y = 4*t
model W parameter Real g = 1; end W; model A outer W w; Real z = w.g*time; end A;
model M inner W w(g=4); A a; Real y = a.z; end M;

// refused: 5.4 the nearest inner; y = 21*t
model A outer Real g; Real z = g; end A; model B inner Real g = 2*time; A a; end B;
model M inner Real g = time; A a; B b; Real y = a.z + 10*b.a.z; end M;

// refused: 5.4 outer two levels below inner; y = 3*t
model A outer Real g; Real z = g; end A; model B A a; end B; model M inner Real g = 3*time; B b; Real y = b.a.z; end M;

// refused: 5.4 outer in an array of components; y = 32*t
model A outer Real g; parameter Real k = 1; Real z = k*g; end A; model M inner Real g = time; A a[2](k={2, 3});
Real y = a[1].z + 10*a[2].z; end M;

// refused: 5.4 an outer connector; y = 1*t
connector C Real e; flow Real f; end C; model A outer C n; C p; equation connect(p, n); p.e = 2*p.f; end A;
model M inner C n; A a; A b; Real y = n.e; equation n.f = 0; a.p.f + b.p.f = time; end M;

// 13.2.1.1 a qualified import; y = 2*t
model M import Corpus.Shared.double; Real y = double(time); end M;

// 13.2.1.1 a renaming import; y = 2 * t + 1.5
model M import S = Corpus.Shared; Real y = S.double(time) + S.c; end M;

// 13.2.1.1 an import of all; y = 2 * t + 1.5
model M import Corpus.Shared.*; Real y = double(time) + c; end M;

// 13.2.1.1 an import of several; y = 2 * t + 1.5
model M import Corpus.Shared.{double, c}; Real y = double(time) + c; end M;

// refused: 13.2.1.1 a local name comes before an import of all; y = 8*t
model M import Corpus.Shared.*; constant Real c = 8; Real y = c*time; end M;

// 13.2.1.1 an import in an enclosing package; y = 3 * t + 1
package P import Corpus.Shared.scaled; model A Real z = scaled(time); end A; end P;
model M P.A a; Real y = a.z; end M;

// 13.2.1.1 imports are not inherited; y = 41.5
model A import Corpus.Shared.c; Real z = c; end A; model M extends A; constant Real c = 4; Real y = z + 10*c; end M;

// 13.2 constants that depend on each other; y = 42
package P constant Real a = 2*b; constant Real b = 3; constant Integer n = size(v, 1); constant Real v[:] =
{1, a, b}; end P; model M Real y = P.a + 10*P.n + P.v[2]; end M;

// 13.2 a table of constants; y = 4 * t + 9
package own constant Real v[2, 3] = [1, 2, 3; 4, 5, 6]; end own; model M Real y = own.v[2, 1]*time + sum(own.v[:, 3]); end M;

// refused: 5.3.1 two functions of one name; y = 32*t
package P function f input Real x; output Real y; algorithm y := 2*x; end f; model A Real z = f(time); end A; end P;
package Q function f input Real x; output Real y; algorithm y := 3*x; end f; model A Real z = f(time); end A; end Q;
model M P.A a; Q.A b; Real y = a.z + 10*b.z; end M;

// refused: 5.3.1 two records of one name; y = 32*t
package P record R Real a = 2*time; end R; model A R r; end A; end P;
package Q record R Real a = 3*time; end R; model A R r; end A; end Q;
model M P.A a; Q.A b; Real y = a.r.a + 10*b.r.a; end M;

// 5.3.1 two enumerations of one name; y = 11
package P type E = enumeration(a, b); model A parameter E e = E.b; Real z = if e == E.b then 1 else 0; end A; end P;
package Q type E = enumeration(b, a); model A parameter E e = E.b; Real z = Integer(e); end A; end Q;
model M P.A a; Q.A b; Real y = a.z + 10*b.z; end M;

// 5.3.1 two constants of one name; y = 32*t
package P constant Real k = 2; model A Real z = k*time; end A; end P;
package Q constant Real k = 3; model A Real z = k*time; end A; end Q;
model M P.A a; Q.A b; Real y = a.z + 10*b.z; end M;

// Chapter 7 of the Modelica Language Specification, 3.6: inheritance, modification and redeclaration.

// 7.1 elements of several bases; y = 3*t
model A Real a = time; end A; model B Real b = 2*time; end B; model M extends A; extends B; Real y = a + b; end M;

// 7.1 the same element from two bases is one; y = 2*t
model A parameter Real k = 2; end A; model B extends A; end B; model C extends A; end C;
model M extends B; extends C; Real y = k*time; end M;

// 7.1 names of a base are looked up where the base is; y = 5*t
package P constant Real k = 5; model A Real z = k*time; end A; end P; constant Real k = 7;
model M extends P.A; Real y = z; end M;

// 7.1 a base of an extended type; y = 2 + t
model M extends B(x(start=2, fixed=true)); Real y = x; end M; model B Real x; equation der(x) = 1; end B;

// 7.1.2 an extends clause below the elements that it uses; y = 2 * t + 2
model M parameter Real p = 2; Real y = z + p; extends A(k=p); end M; model A parameter Real k = 1;
Real z = k*time; end A;

// 7.2 the outer modifier is stronger; y = 4*t
model A parameter Real k = 1; end A; model B A a(k=2); end B; model C B b(a(k=3)); end C;
model M C c(b(a(k=4))); Real y = c.b.a.k*time; end M;

// 7.2 a modifier with a dotted name; y = 5
model A parameter Real k = 1; end A; model B A a; end B; model M B b(a.k=5); Real y = b.a.k; end M;

// 7.2 a modifier is evaluated where it is written; y = 6
model A parameter Real k = 1; parameter Real p = 100; end A; model M parameter Real p = 3; A a(k=2*p);
Real y = a.k; end M;

// refused: 7.2 a modifier of a short class is evaluated where it is written; y = 6
constant Real p = 3; model A constant Real p = 100; parameter Real k = 1; end A; model B = A(k=2*p);
model M B b; Real y = b.k; end M;

// 7.2.3 attributes are modified next to the value; y = 4 + t
model A Real x(start=1, fixed=true); equation der(x) = 1; end A; model M A a(x(start=4)); Real y = a.x; end M;

// 7.2.4 a modifier of a part of an inherited component; y = 65
model A parameter Real k = 1; parameter Real m = 2; end A; model B A a(k=5); end B;
model M extends B(a(m=6)); Real y = a.k + 10*a.m; end M;

// 7.2.5 each gives all elements one value; y = 6*t
model A parameter Real k = 1; Real z = k*time; end A; model M A a[3](each k=2); Real y = sum(a.z); end M;

// 7.2.5 a vector gives each element its own value; y = 5*t
model A parameter Real k = 1; Real z = k*time; end A; model M A a[3](k={1, 2, 4}); Real y = a[3].z + a[1].z; end M;

// refused: 7.2.5 a vector through two levels of arrays; y = 32
model A parameter Real k[2] = {1, 1}; end A; model M A a[2](k=[1, 2; 3, 4]);
Real y = a[1].k[2] + 10*a[2].k[1]; end M;

// 7.2.6 final fixes a value; y = 6*t
model A final parameter Real k = 3; parameter Real m = 1; end A; model M A a(m=2); Real y = a.k*a.m*time; end M;

// 7.3 a redeclared component keeps the modifiers of its constraint; y = 30
partial model L parameter Real k = 1; Real z; end L; model A extends L; equation z = k; end A;
model B extends L; equation z = 10*k; end B;
model C replaceable A a constrainedby L(k=3); end C; model M C c(redeclare B a); Real y = c.a.z; end M;

// refused: 7.3 a redeclared component with a modifier of its own; y = 57
model A parameter Real k = 1; Real z = k; end A; model B extends A; parameter Real m = 2; end B;
model C replaceable A a; end C; model M C c(redeclare B a(m=5, k=7)); Real y = c.a.z + 10*c.a.m; end M;

// refused: 7.3 a redeclared class of several components; y = 6*t
model A Real z = 1; end A; model B Real z = 2*time; end B; model C replaceable model K = A; K a; K b[2]; end C;
model M C c(redeclare model K = B); Real y = c.a.z + sum(c.b.z); end M;

// refused: 7.3 a redeclaration in an extends clause; y = 2*t
model A Real z = 1; end A; model B Real z = 2*time; end B; model C replaceable model K = A; K a; end C;
model M extends C(redeclare model K = B); Real y = a.z; end M;

// refused: 7.3 a redeclaration of a parameter's value; y = 3*t
model C replaceable parameter Real r = 2; Real z = r*time; end C; model M C c(redeclare parameter Real r = 3);
Real y = c.z; end M;

// refused: 7.3 a redeclared package; y = 23*t
package P constant Real k = 2; end P; package Q constant Real k = 3; end Q;
model C replaceable package K = P; Real z = K.k*time; end C; model M C c(redeclare package K = Q); C d;
Real y = c.z + 10*d.z; end M;

// refused: 7.3 a redeclared record; y = t + 1
record R Real a; end R; record S extends R; Real b; end S; model C replaceable record K = R; K r; end C;
model M C c(redeclare record K = S); Real y = c.r.a + c.r.b; equation c.r.a = time; c.r.b = 1; end M;

// 7.3 a redeclared function; y = t + 8; w = (t + 1) ** 2
model C replaceable function f = Shared.square constrainedby Shared.law; Real z = f(time + 1); end C;
function own extends Shared.law; algorithm y := x + 7; end own;
model M C c(redeclare function f = own); C d; Real y = c.z; Real w = d.z; end M;

// refused: 7.3.1 a class that extends the one it replaces; y = 3
partial model A replaceable model K Real z = 1; end K; end A; model M extends A;
redeclare model extends K Real w = 2; end K; K k; Real y = k.z + k.w; end M;

// 7.3.2 a constraint that is less than the declaration; y = 5
partial model L Real z; end L; model A extends L; parameter Real k = 1; equation z = k; end A;
model B extends L; equation z = 5; end B; model C replaceable A a constrainedby L; end C;
model M C c(redeclare B a); Real y = c.a.z; end M;

// refused: 7.3.3 redeclared twice through replaceable; y = 24
model A Real z = 1; end A; model B Real z = 2; end B; model D Real z = 4; end D;
model C replaceable A a; end C; model E extends C(redeclare replaceable B a); end E;
model M E e(redeclare D a); E f; Real y = e.a.z + 10*f.a.z; end M;

// refused: 7.2 dotted modifiers of an extends clause; y = 3 + t
model A Real v(start=20, fixed=true); equation der(v) = 1; end A; model B A p(v(start=10)); end B;
model C extends B(p.v(start=5)); end C; model M extends C(p.v(start=3)); Real y = p.v; end M;

// refused: 7.2.5 each in a matrix of components; y = 36 + 600 + 2000
model A parameter Real p = 1; parameter Real q = 2; end A; model M parameter Real p = 3; A a[2, 3](each p=2*p);
Real y = sum(a.p) + 100*a[2, 3].p + 1000*a[1, 3].q; end M;

// refused: 7.3 a redeclared function with a modifier of its input; y = math.exp(t)
function own input Real x; input Real k = 1; output Real y; algorithm y := x + k; end own;
model C replaceable function g = own; Real z(start=1, fixed=true); equation der(z) = g(z); end C;
model M C c(redeclare function g = own(k=0)); Real y = c.z; end M;

// Chapter 8 of the Modelica Language Specification, 3.6: equations, events, initialization.

// 8.3.1 equations in any order and form; y = 2 * (t + 3) + 3
model M Real a; Real b; Real y; equation 2*a + b = y; b = 3; a - time = b; end M;

// 8.3.1 an equation between arrays; y = 2 + t
model M Real a[3]; Real b[3] = {1, 2, 3}; Real y = a[2]; equation a - b = {time, time, 0}; end M;

// 8.3.1 several results of a function; y = math.hypot(t, 1); phi = math.atan2(1, t)
model M Real r; Real phi; Real y = r; equation (r, phi) = Shared.polar(time); end M;

// refused: 8.3.1 a result that is left out; y = math.atan2(1, t + 1)
model M Real y; equation (, y) = Shared.polar(time + 1); end M;

// 8.3.2 for equations; y = 8*t
model M Real x[4]; Real y = x[4]; equation x[1] = time; for i in 2:4 loop x[i] = 2*x[i - 1]; end for; end M;

// 8.3.2 nested for equations; y = 2 * t + 3 + 10 * (t + 2)
model M Real x[2, 3]; Real y = x[2, 3] + 10*x[1, 2]; equation for i in 1:2 loop for j in 1:3 loop
x[i, j] = i*time + j; end for; end for; end M;

// 8.3.2 a for equation with two iterators; y = 2 * t + 3
model M Real x[2, 3]; Real y = x[2, 3]; equation for i in 1:2, j in 1:3 loop x[i, j] = i*time + j; end for; end M;

// 8.3.2 for equations over other ranges; y = 7 * t + 1
model M Real x[6]; Real y = sum(x); equation for i in 1:2:5 loop x[i] = time; end for;
for i in {2, 6} loop x[i] = 2*time; end for; for i in 4:-1:4 loop x[i] = 1; end for; end M;

// 8.3.2 a for equation over the size of an array; y = 6*t
model M parameter Integer n = 3; Real x[n]; Real y = sum(x); equation for i loop x[i] = i*time; end for; end M;

// 8.3.2 a for equation that never runs; y = 1*t
model M Real y; equation y = time; for i in 2:1 loop y = 1; end for; end M;

// refused: 8.3.3 connect in a for equation; y = 2*t
connector C Real e; flow Real f; end C; model R C a; C b; equation a.f + b.f = 0; a.e - b.e = a.f; end R;
model M R r[3]; Real y = r[1].a.f; equation for i in 1:2 loop connect(r[i].b, r[i + 1].a); end for;
r[1].a.e = 6*time; r[3].b.e = 0; end M;

// 8.3.4 an if equation with events; y = 3 if t <= 0.25 else 4 * t if t <= 0.5 else 1
model M Real x(start=0, fixed=true); Real y; equation der(x) = 2; if x > 1 then y = 1; elseif x > 0.5 then
y = 2*x; else y = 3; end if; end M;

// 8.3.4 branches that give different equations; y = 21 if t < 0.5 else 11 * t + 1
model M Real a; Real b; Real y = a + 10*b; equation if time < 0.5 then a = 1; b = 2*a; else b = time;
a = b + 1; end if; end M;

// 8.3.4 an if equation of a parameter with different numbers of unknowns; y = 2*t
model M parameter Boolean has = false; Real y; equation if has then y = 1; else y = 2*time; end if; end M;

// 8.3.5 when with a state event; y = 0 if t < math.log(1.5) else 0.5 + math.log(1.5)
model M Real x(start=0, fixed=true); discrete Real y(start=0, fixed=true); equation der(x) = 1 + x;
when x > 0.5 then y = x + time; end when; end M;

// 8.3.5 when with time >; y = 0 if t < 0.4 else 7
model M Integer y(start=0, fixed=true); equation when time > 0.4 then y = 7; end when; end M;

// 8.3.5 when with time >=; y = 0 if t < 0.4 else 7
model M Integer y(start=0, fixed=true); equation when time >= 0.4 then y = 7; end when; end M;

// 8.3.5 a condition that is true at the start makes no edge; y = 0
model M Integer y(start=0, fixed=true); equation when time >= 0 then y = 7; end when; end M;

// 8.3.5 elsewhen; y = 0 if t < 0.1 else 1 if t < 0.4 else 2 if t < 0.7 else 3
model M Real x(start=0, fixed=true); Integer y(start=0, fixed=true); equation der(x) = 1;
when x > 0.7 then y = 3; elsewhen x > 0.4 then y = 2; elsewhen x > 0.1 then y = 1; end when; end M;

// refused: 8.3.5 the first of two branches at one instant; y = sum((10 if k % 2 == 1 else 1 for k in range(1, math.floor(5 * t + 1e-09) + 1)))
model M Integer y(start=0, fixed=true); equation when sample(0.2, 0.4) then y = pre(y) + 10;
elsewhen sample(0.2, 0.2) then y = pre(y) + 1; end when; end M;

// 8.3.5 when with several conditions; y = 0 if t < 0.3 else 1 if t < 0.6 else 2
model M Integer y(start=0, fixed=true); equation when {time > 0.3, time > 0.6} then y = pre(y) + 1; end when; end M;

// 8.3.5 when with initial() among the conditions; y = 1 if t < 0.6 else 2
model M Integer y(start=0); equation when {initial(), time > 0.6} then y = pre(y) + 1; end when; end M;

// 8.3.5 a condition of and and or; y = 0 if t < 0.5 else 1
model M Real x(start=0, fixed=true); Integer y(start=0, fixed=true); equation der(x) = 1;
when x > 0.2 and time > 0.5 or x > 0.8 then y = pre(y) + 1; end when; end M;

// 8.3.5 equations of one when clause are solved in any order; y = 0 if t < 0.5 else 6
model M discrete Real y(start=0, fixed=true); discrete Real a(start=0, fixed=true); equation
when time > 0.5 then y = 2*a; a = 3; end when; end M;

// 8.3.5 one when clause triggers another; y = 0 if t < 0.5 else 2
model M Integer a(start=0, fixed=true); Integer y(start=0, fixed=true); equation
when time > 0.5 then a = 2; end when; when a > 1 then y = pre(y) + a; end when; end M;

// 8.3.5 the next event is calculated in a when clause; y = 0 if t < 0.1 else 1 + math.floor((t - 0.1) / 0.25 + 1e-09)
model M discrete Real next(start=0.1, fixed=true); Integer y(start=0, fixed=true); equation
when time >= pre(next) then next = pre(next) + 0.25; y = pre(y) + 1; end when; end M;

// 8.3.6 reinit: a bouncing ball; h = bounces(t)[0]; n = bounces(t)[1]
model M Real h(start=0.5, fixed=true); Real v(start=0, fixed=true); Integer n(start=0, fixed=true); equation
der(h) = v; der(v) = -9.81; when h < 0 and v < 0 then reinit(v, -0.8*pre(v)); n = pre(n) + 1; end when; end M;

// 8.3.6 reinit at a time event without discrete variables; x = 1 - t if t < 0.25 else 5 - (t - 0.25) if t < 0.75 else 5 - (t - 0.75)
model M Real x(start=1, fixed=true); equation der(x) = -1; when sample(0.25, 0.5) then reinit(x, 5); end when; end M;

// 8.3.6 reinit in one of two branches; x = t if t < 0.3 else 0.5 + (t - 0.3) if t < 0.4 else (t - 0.4) % 0.6
model M Real x(start=0, fixed=true); equation der(x) = 1; when x > 0.6 then reinit(x, 0);
elsewhen time > 0.3 then reinit(x, 0.5); end when; end M;

// 8.3.7 an assertion that holds; y = 1*t
model M Real y = time; equation assert(y < 2, "y is " + String(y)); end M;

// 8.3.7 an assertion of level warning; y = 1*t
model M Real y = time; equation assert(y < 0.5, "y is large", AssertionLevel.warning); end M;

// refused: 8.3.8 terminate; y = 1*t
model M Real y = time; equation when time > 5 then terminate("late"); end when; end M;

// 8.4 a chain of Boolean equations at an event; y = 0 if t < 0.5 else 1
model M Boolean a = time > 0.5; Boolean b = not a; Boolean c = not b; Boolean d = a and c;
Real y = if d then 1 else 0; end M;

// 8.5 hysteresis with pre; x = hysteresis(t)
model M Real x(start=0.2, fixed=true); Boolean up(start=true, fixed=true); equation der(x) = if up then 5 else -5;
up = pre(up) and x < 1 or x < 0.2; end M;

// 8.5 a stick-slip oscillator; x = stick_slip()(t)
model M parameter Real v = 1; Real x(start=0, fixed=true); Real w(start=1, fixed=true);
Boolean slides(start=false, fixed=true); equation slides = 10*x > 4 or pre(slides) and w < v;
der(x) = w; der(w) = if slides then 2 - 10*x else 0; end M;

// 8.5 two events at one instant; y = 0 if t < 0.5 else 1; n = 0 if t < 0.5 else 1
model M Real a(start=0, fixed=true); Real b(start=1, fixed=true); Integer y(start=0, fixed=true);
Integer n(start=0, fixed=true); equation der(a) = 1; der(b) = -1; when a > 0.5 then y = pre(y) + 1; end when;
when b < 0.5 then n = pre(n) + 1; end when; end M;

// 8.5 a relation that changes twice within three output intervals; y = 0 if t < 0.48 else 1
model M Real x(start=0, fixed=true); Integer y(start=0, fixed=true); equation der(x) = 1;
when abs(x - 0.5) < 0.02 then y = pre(y) + 1; end when; end M;

// 8.6 initial equations; x = 2 * math.cos(t) + math.sin(t)
model M Real x; Real v; equation der(x) = v; der(v) = -x; initial equation x + v = 3; x - v = 1; end M;

// 8.6 a steady start; x = 2 + t + math.exp(-t)
model M Real x; Real u = 3 + time; initial equation der(x) = 0; equation der(x) = u - x; end M;

// 8.6 an initial equation for an algebraic variable; y = 6 * math.exp(-t)
model M Real x; Real y = 2*x; initial equation y = 6; equation der(x) = -x; end M;

// 8.6 fixed of an algebraic variable; y = 6 * math.exp(-t)
model M Real x(start=1); Real y(start=6, fixed=true) = 2*x; equation der(x) = -x; end M;

// 8.6 a nonlinear initial equation; x = 2 + t
model M Real x(start=1); initial equation x^3 + x = 10; equation der(x) = 1; end M;

// refused: 8.6 a parameter with fixed=false; x = math.exp(-3 * t)
model M parameter Real k(fixed=false, start=1); Real x(start=1, fixed=true); initial equation der(x) = -3;
equation der(x) = -k*x; end M;

// 8.6 an initial equation for a discrete variable; y = 4 if t < 0.5 else 5
model M discrete Real y; initial equation y = 4; equation when time > 0.5 then y = pre(y) + 1; end when; end M;

// 8.6 an initial equation for pre; y = 4 if t < 0.5 else 5
model M Integer y; initial equation pre(y) = 4; equation when time > 0.5 then y = pre(y) + 1; end when; end M;

// 8.6 an initial if equation; x = 2 + t
model M parameter Boolean steady = false; Real x; initial equation if steady then der(x) = 0; else x = 2; end if;
equation der(x) = 1; end M;

// 8 a linear system of three equations; y = float(np.linalg.solve([[1, 1, 1], [1, -1, 0], [0, 1, 2]], [6 * t, -t, 8 * t]) @ [1, 10, 100])
model M Real a; Real b; Real c; Real y = a + 10*b + 100*c; equation a + b + c = 6*time; a - b = -time;
b + 2*c = 8*time; end M;

// 8 a linear system whose matrix varies; y = float(np.sum(np.linalg.solve([[1 + t, 1], [1, -t]], [1, 2])))
model M Real a; Real b; Real y = a + b; equation (1 + time)*a + b = 1; a - time*b = 2; end M;

// 8 a system of two nonlinear equations; y = (lambda b: math.exp(-b) + b)(brentq(lambda b: (math.exp(-b) + b) ** 2 + b * b - 4 - t, 0.5, 3, xtol=1e-14))
model M Real a(start=1); Real b(start=1); Real y = a; equation a^2 + b^2 = 4 + time; a = exp(-b) + b; end M;

// 8 derivatives in an implicit equation; d = brentq(lambda d: d + d ** 3 - 2 - t, 0, 3, xtol=1e-14)
model M Real x(start=0, fixed=true); Real d(start=1); equation d + d^3 = 2 + time; d = der(x); end M;

// 8 index reduction: two masses that move as one; y = 1 + 2 * t + 0.5 * t * t
model M Real a(start=1, fixed=true); Real b; Real v(start=2, fixed=true); Real w; Real f; Real y = b; equation
der(a) = v; der(b) = w; der(v) = f; 2*der(w) = 3 - f; a = b; end M;

// 8 index reduction: a pendulum in Cartesian coordinates; y = pendulum()(t)
model M Real x(start=6, fixed=true); Real z(start=-8); Real u(start=0, fixed=true); Real w; Real f; Real y = z;
equation der(x) = u; der(z) = w; der(u) = -f*x; der(w) = -f*z - 9.81; x^2 + z^2 = 100; end M;

// 8 index reduction with a driven position; y = -12 * math.sin(2 * t)
model M Real x; Real v; Real f; Real y = f; equation x = sin(2*time); der(x) = v; 3*der(v) = f; end M;

// 8 a stiff decay; y = t * t / 2 - 0.001 * t + (2 + 0.001) / 1000 * (1 - math.exp(-1000 * t))
model M Real x(start=2, fixed=true); Real y(start=0, fixed=true); equation der(x) = -1000*(x - time);
der(y) = x; end M;

// 8 an oscillator; x = math.cos(10 * t)
model M Real x(start=1, fixed=true); Real v(start=0, fixed=true); equation der(x) = v; der(v) = -100*x; end M;

// refused: 8.3.2 a range that depends on the outer iterator; y = 16*t
model M Real v[4] = {1, 2, 3, 4}*time; Real x[4]; Real y = x[4] + 10*x[2]; equation x[1] = 0;
for i in 2:4 loop x[i] = sum({v[j] for j in 1:i - 1}); end for; end M;

// 8.3.5 a table that a discrete index reads; y = 0.2 if t < 0.2 else 0.5 if t < 0.5 else 0.6 if t < 0.6 else 5
model M parameter Real v[4] = {0.2, 0.5, 0.6, 5}; Integer i(start=1, fixed=true);
discrete Real y(start=0.2, fixed=true); equation when time > pre(y) then i = pre(i) + 1; y = v[i]; end when; end M;

// 8.3.5 when in one branch of an if equation; a.n = math.floor(t / 0.1 + 1e-09); b.n = 7; c.n = 0
model A parameter Real p = 1; Integer n(start=0, fixed=true); equation if p > 1 then n = 7; elseif p > 0 then
when sample(0.1, 0.1) then n = pre(n) + 1; end when; else n = 0; end if; end A; model M A a; A b(p=2); A c(p=-1); end M;

// 8.3.5 an if equation over a parameter in a when equation; a.n = 0 if t < 0.5 else 1; b.n = 0 if t < 0.5 else 10
model A parameter Boolean p = true; Integer n(start=0, fixed=true); equation when time > 0.5 then
if p then n = pre(n) + 1; else n = pre(n) + 10; end if; end when; end A; model M A a; A b(p=false); end M;

// 10.6.9 a part of an array of components in an array of components; y[2] = 2*t; z[2] = 2*t
record Contact Real slip; end Contact; model Wheel Contact contact[2]; equation contact[1].slip = time;
contact[2].slip = 2*time; end Wheel; model M Wheel wheels[2]; Real y[2]; Real z[2]; equation
y = {wheels[i].contact[2].slip for i in 1:2}; z[1] = wheels[1].contact[2].slip; z[2] = z[1]; end M;

// 10.6.9 an array in an array of components; y[1] = 2*t; y[2] = 2*t; w[1,1] = t; w[1,2] = 2*t; w[2,1] = t
model A Real z[2] = {1, 2}*time; end A; model M A a[2]; Real y[2] = {a[i].z[2] for i in 1:2}; Real w[2, 2] = a.z; end M;

// 10.6.9 an element in the class of an array of components; y[1] = 2*t; y[2] = 2*t
model B Real F[2] = {1, 2}*time; end B; model A B b; Real y = b.F[2]; end A; model M A a[2]; Real y[2] = a.y; end M;

// 8.3.5 elements of an array in a when equation; n[1] = 9 * math.floor(t / 0.1 + 1e-09); n[2] = 2 * math.floor(t / 0.1 + 1e-09); k = math.floor(t / 0.1 + 1e-09)
model M discrete Real n[2](each start=0, each fixed=true); Integer k(start=0, fixed=true); equation
when sample(0.1, 0.1) then n[2] = pre(n[2]) + 2; k = pre(k) + 1; n[1] = 7*k + n[2]; end when; end M;

// 8.3.5 a for equation in a when equation; y = 0 if t < 0.5 else 15.5 if t < 0.7 else 31.2
model M discrete Real n[2, 3](each start=0, each fixed=true); Real y = n[1, 3] + 2*n[2, 3] + n[2, 1]; equation
when {time > 0.5, time > 0.7} then for i in 1:2, j in 1:3 loop n[i, j] = pre(n[i, j]) + i*j - (if i == j then 0 else
(if j == 1 then 2 - time else 0)); end for; end when; end M;

// 8.3.5 a when equation in a for equation; a[2].k[1] = math.floor(t / 0.1 + 1e-09); a[1].k[2] = 2 * math.floor(t / 0.1 + 1e-09); a[1].x[2] = 2*t
model A parameter Integer m = 2; Integer k[m](each start=0, each fixed=true); Real x[m](each start=0, each fixed=true);
equation for i in 1:m loop der(x[i]) = i; when sample(0.1, 0.1) then k[i] = pre(k[i]) + i; end when; end for; end A;
model M A a[2]; end M;

// 8.3.5 a controller of four groups next to a class with a size of that name; y[1] = 1 + math.floor(t / 0.1 + 1e-09); y[2] = 1 + 2 * (5 - abs(5 - math.floor(t / 0.1 + 1e-09))); y[3] = 1 + 3 * (3 - abs(3 - math.floor(t / 0.1 + 1e-09))); y[4] = 1 + 4 * math.floor(t / 0.1 + 1e-09); a.z[2] = t
model A parameter Integer groups = 2; Real z[groups] = fill(time, groups); end A;
model M "controller of" + " groups" parameter Integer groups = 4; parameter Real k = 1.1; Real slip[groups] = {0, 1, 2, 3}*time; A a;
Boolean low[groups](each start=false, each fixed=true); Real y[groups](each start=1, each fixed=true); equation
when sample(0.1, 0.1) then for i in 1:groups loop low[i] = slip[mod(i, 4) + 1] > k;
y[i] = if low[i] then pre(y[i]) - i else pre(y[i]) + i; end for; end when; end M;

// refused: 8.3.5 elsewhen in an algorithm; y = 0 if t < 0.3 else 1 if t < 0.6 else 2
model M Integer y(start=0, fixed=true); algorithm when time > 0.3 then y := 1; elsewhen time > 0.6 then y := 2;
end when; end M;

// Chapters 9 and 15 of the Modelica Language Specification, 3.6: connectors and connections.

// 9.2 flows sum to zero and potentials are equal; y = 9*t
connector C Real e; flow Real f; end C;
model R parameter Real k = 1; C a; C b; equation a.f + b.f = 0; a.e - b.e = k*a.f; end R;
model S C a; equation a.e = 6*time; end S; model G C a; equation a.e = 0; end G;
model M S s; G g; R r1; R r2(k=2); Real y = -s.a.f; equation connect(s.a, r1.a); connect(s.a, r2.a);
connect(r1.b, g.a); connect(r2.b, g.a); end M;

// 9.2 a chain of connections is one set; y = 18*t
connector C Real e; flow Real f; end C;
model R parameter Real k = 1; C a; C b; equation a.f + b.f = 0; a.e - b.e = k*a.f; end R;
model S C a; equation a.e = 6*time; end S; model G C a; equation a.e = 0; end G;
model M S s; G g; R r1; R r2; R r3; Real y = r1.a.f + r2.a.f + r3.a.f; equation
connect(r1.a, r2.a); connect(r2.a, r3.a); connect(r3.a, s.a); connect(r1.b, g.a); connect(g.a, r2.b);
connect(r2.b, r3.b); end M;

// 9.2 a connection that is made twice; y = 6*t
connector C Real e; flow Real f; end C;
model R parameter Real k = 1; C a; C b; equation a.f + b.f = 0; a.e - b.e = k*a.f; end R;
model S C a; equation a.e = 6*time; end S; model G C a; equation a.e = 0; end G;
model M S s; G g; R r; Real y = r.a.f; equation connect(s.a, r.a); connect(r.a, s.a);
connect(r.b, g.a); end M;

// 9.2 the flow of an unconnected connector is zero; y = 6*t
connector C Real e; flow Real f; end C;
model R parameter Real k = 1; C a; C b; equation a.f + b.f = 0; a.e - b.e = k*a.f; end R;
model S C a; equation a.e = 6*time; end S; model G C a; equation a.e = 0; end G;
model M S s; R r; R open; Real y = r.b.e + open.a.f; equation connect(s.a, r.a); connect(r.b, open.a); end M;

// 9.2 flows of an outside connector have the other sign; y = 3*t
connector C Real e; flow Real f; end C;
model R parameter Real k = 1; C a; C b; equation a.f + b.f = 0; a.e - b.e = k*a.f; end R;
model S C a; equation a.e = 6*time; end S; model G C a; equation a.e = 0; end G;
model P C a; C b; R r1; R r2; equation connect(a, r1.a); connect(r1.b, r2.a); connect(r2.b, b); end P;
model M S s; G g; P p; Real y = p.a.f; equation connect(s.a, p.a); connect(p.b, g.a); end M;

// 9.2 outside connectors through two levels; y = 6*t
connector C Real e; flow Real f; end C;
model R parameter Real k = 1; C a; C b; equation a.f + b.f = 0; a.e - b.e = k*a.f; end R;
model S C a; equation a.e = 6*time; end S; model G C a; equation a.e = 0; end G;
model P C a; C b; R r; equation connect(a, r.a); connect(r.b, b); end P;
model Q C a; C b; P p; equation connect(a, p.a); connect(p.b, b); end Q;
model M S s; G g; Q q; Real y = q.a.f; equation connect(s.a, q.a); connect(q.b, g.a); end M;

// 9.2 arrays of connectors; y = 3 * t + 20
connector C Real e; flow Real f; end C;
model R parameter Real k = 1; C a; C b; equation a.f + b.f = 0; a.e - b.e = k*a.f; end R;
model S C a; equation a.e = 6*time; end S; model G C a; equation a.e = 0; end G;
model P C c[2]; equation c[1].e = 2*c[1].f; c[2].e = 3*c[2].f; end P;
model Q C c[2]; equation c.e = {6*time, 6}; end Q;
model M P p; Q q; Real y = p.c[1].f + 10*p.c[2].f; equation connect(p.c, q.c); end M;

// 9.2 an element of an array of connectors; y = 2*t
connector C Real e; flow Real f; end C;
model R parameter Real k = 1; C a; C b; equation a.f + b.f = 0; a.e - b.e = k*a.f; end R;
model S C a; equation a.e = 6*time; end S; model G C a; equation a.e = 0; end G;
model P C c[2]; equation c[1].e = 2*c[1].f; c[2].e = 3*c[2].f; end P;
model M P p; S s; G g; Real y = p.c[2].f; equation connect(p.c[2], s.a); connect(p.c[1], g.a); end M;

// 9.1 a connector in a connector; y = 3 * t + 4
connector C Real e; flow Real f; end C;
model R parameter Real k = 1; C a; C b; equation a.f + b.f = 0; a.e - b.e = k*a.f; end R;
model S C a; equation a.e = 6*time; end S; model G C a; equation a.e = 0; end G;
connector D C p; C q; end D; model A D d; equation d.p.e = 2*d.p.f; d.q.e = 3*d.q.f; end A;
model B D d; equation d.p.e = 6*time; d.q.e = 12; end B; model M A a; B b; Real y = a.d.p.f + a.d.q.f; equation
connect(a.d, b.d); end M;

// 9.1 a connector with arrays; y = 2 * t + 3
connector C Real e[3]; flow Real f[3]; end C; model A C c; equation c.e = 2*c.f; end A;
model B C c; equation c.e = {2, 4*time, 6}; end B; model M A a; B b; Real y = a.c.f[2] + a.c.f[3]; equation
connect(a.c, b.c); end M;

// 9.1 causal connectors; y = 10*t
connector I = input Real; connector O = output Real; block G parameter Real k = 2; I u; O v; equation v = k*u;
end G; block S O v = time; end S; model M S s; G g; G h(k=5); Real y = h.v; equation connect(s.v, g.u);
connect(g.v, h.u); end M;

// 9.1 one output to several inputs; y = 6*t
connector I = input Real; connector O = output Real; block G I u; Real z = 3*u; end G; block S O v = time; end S;
model M S s; G g; G h; Real y = g.z + h.z; equation connect(s.v, g.u); connect(s.v, h.u); end M;

// 9.1 Boolean and Integer connectors; y = 4 if t > 0.5 else 0
connector I = input Boolean; connector O = output Boolean; connector N = input Integer;
connector P = output Integer; block S O b = time > 0.5; P n = 4; end S;
block G I b; N n; Real z = if b then n else 0; end G; model M S s; G g; Real y = g.z; equation
connect(s.b, g.b); connect(s.n, g.n); end M;

// 9.1 vectors of signals; y = 1 + 10 * t + 300
connector I = input Real; connector O = output Real; block S O v[3] = {1, time, 3}; end S;
block G I u[3]; Real z = u[1] + 10*u[2] + 100*u[3]; end G; model M S s; G g; Real y = g.z; equation
connect(s.v, g.u); end M;

// refused: 9.1.3 expandable connectors; y = 2*t
expandable connector B end B; connector I = input Real; connector O = output Real; block S O v = time; end S;
block G I u; Real z = 2*u; end G; model M B bus; S s; G g; Real y = g.z; equation connect(s.v, bus.v);
connect(bus.v, g.u); end M;

// 9.3 a parameter in a connector; y = 3*t
connector C parameter Integer n = 2; Real e; flow Real f; end C; model A C c(n=3); equation c.e = c.n*c.f; end A;
model B C c(n=3); equation c.f = -time; end B; model M A a; B b; Real y = a.c.e; equation connect(a.c, b.c); end M;

// 9.4 overconstrained connections; y = 1
type O extends Real; function equalityConstraint input O a; input O b; output Real r[0]; algorithm end
equalityConstraint; end O; connector C O o; flow Real f; end C; model M C a; Real y = 1; equation
Connections.root(a.o); a.o = 1; end M;

// 15.1 stream connectors; y = 5
connector C Real p; flow Real m; stream Real h; end C; model A C c; equation c.m = -1; c.h = 5; end A;
model B C c; Real z = inStream(c.h); equation c.p = 1; c.h = 3; end B; model M A a; B b; Real y = b.z; equation
connect(a.c, b.c); end M;

// Chapter 10 of the Modelica Language Specification, 3.6: arrays.

// 10.1 arrays of three dimensions; y = 2 + 6 + 4 * t + 10 * sum((1 + 2 * j + 8 * t for j in (1, 2, 3)))
model M Real a[2, 3, 2]; Real y = a[2, 3, 1] + 10*sum(a[1, :, 2]); equation for i in 1:2, j in 1:3, k in 1:2 loop
a[i, j, k] = i + 2*j + 4*k*time; end for; end M;

// 10.1 empty arrays; y = t + 3
model M Real a[0]; Real b[0, 3]; parameter Real p[:] = fill(1.0, 0); Real y = time + sum(a) + sum(p) + size(b, 2); end M;

// 10.2 flexible sizes of function inputs; y = 32 + t
function own input Real a[:, :]; output Real y; algorithm y := size(a, 1) + 10*size(a, 2) + a[2, 1]; end own;
model M Real y = own([1, 2, 3; time, 5, 6]); end M;

// 10.3.2 size of every dimension; y = 32
model M Real a[2, 3]; Integer n[2] = size(a); Real y = n[1] + 10*n[2]; equation a = fill(time, 2, 3); end M;

// 10.3.3 matrices of constructors; y = 4 + t + 30 + 100 * (5 + t)
model M Real a[2, 2] = diagonal({1, 2}) + identity(2)*time + zeros(2, 2) + 3*ones(2, 2);
Real y = a[1, 1] + 10*a[1, 2] + 100*a[2, 2]; end M;

// 10.3.4 reductions of empty arrays; y = 10
model M Real a[0]; Real y = sum(a) + 10*product(a); end M;

// 10.3.4 reductions over an empty range in equations; a = 0; b = 1; c = 0; d = 1; y = 1; z = 1; v = 0; w = 1
model M parameter Integer n = 0; Real a; Real b; Integer c; Integer d; Real y; Real z; Real v; Boolean w; equation
a = sum(time + k for k in 1:n); b = product(time + k for k in 1:n); c = sum(1 + k for k in 1:n);
d = product(1 + k for k in 1:n); v = sum(time*j + k for j in 1:2, k in n:-1:1); w = min(k > 1 for k in 1:n);
y = if min(time + k for k in 1:n) > 8e304 and max(time + k for k in 1:n) < -8e304 then 1 else 0;
z = if min(2*k for k in 1:n) >= 2147483647 and max(2*k for k in 1:n) <= -2147483647 then 1 else 0; end M;

// 10.3.4 reductions over an empty range in declarations; y = 1; z = 1
model M parameter Integer n = 0; Integer l = min(2*k for k in 1:n); Integer m = max(2*k for k in 1:n);
Real y = if min(time + k for k in 1:n) > 8e304 and max(time + k for k in 1:n) < -8e304 then 1 else 0;
Real z = if l >= 2147483647 and m <= -2147483647 then 1 else 0; end M;

// 10.3.4 a range that is empty in one of two components; y = t + (1 if t > 0.5 else t)
model A parameter Integer n = 1; Real x[n]; Real y; equation x = fill(time, n);
y = sum(x[k] for k in 1:size(x, 1)) + sum(if time > 0.5 then x[k]/time else time for k in 1:n); end A;
model M A a; A b(n=0); Real y; equation y = a.y + b.y; end M;

// 10.4.1 array constructors over an empty range in equations; a = 0; b = 1; c = 20; d = 3 * t
model M parameter Integer n = 0; Real a; Real b; Real c; Real d; equation a = size({time + k for k in 1:n}, 1);
b = size(cat(1, {time + k for k in 1:n}, {time}), 1); c = sum(size({{j*k*time for j in 1:2} for k in 1:n}).*{1, 10});
d = sum({{j*k*time for j in 1:2} for k in 1:n + 1}); end M;

// refused: 10.3.4 a reduction over an array; y = t * t + 13
model M Real v[3] = {time, 2, 3}; Real y = sum(x^2 for x in v); end M;

// 10.3.4 a reduction with a deduced range; y = t + 13
model M Real v[3] = {time, 2, 3}; Real y = sum(i*v[i] for i); end M;

// 10.3.4 max and min of states; y = max(t, 0.5, 0.2 - t) + 10 * min(t, 0.5, 0.2 - t)
model M Real v[3](start={0, 0.5, 0.2}, each fixed=true); Real y = max(v) + 10*min(v); equation
der(v) = {1, 0, -1}; end M;

// refused: 10.4.1 constructors of iterators with arrays; y = 3
model M Real a[3, 2] = {{i, j*time} for j in 1:1, i in 1:3}[:, 1, :]; Real y = a[3, 1]; end M;

// 10.4.1 an array constructor of vectors; y = 6 * t + 20
model M Real a[2, 3] = {{1, 2, 3}, {4, 5, 6}*time}; Real y = a[2, 3] + 10*a[1, 2]; end M;

// 10.4.2 concatenation of matrices and vectors; y = t + 40 + 600
model M Real v[2] = {time, 2}; Real a[3, 3] = [v, [1, 2; 3, 4]; 5, 6, 7];
Real y = a[1, 1] + 10*a[2, 3] + 100*a[3, 2]; end M;

// 10.4.2 cat along the second dimension; y = 4 * t + 20
model M Real a[2, 3] = cat(2, [1; 2], [3, 4*time; 5, 6]); Real y = a[1, 3] + 10*a[2, 1]; end M;

// 10.5 slices of a matrix; y = (15 + 110 + 1800)*t
model M Real a[3, 3]; Real y = sum(a[2, :]) + 10*sum(a[2:3, 1]) + 100*sum(a[:, 3]); equation
a = [1, 2, 3; 4, 5, 6; 7, 8, 9]*time; end M;

// 10.5 an index that is an array; y = 114*t
model M Real v[4] = {1, 2, 3, 4}*time; Real w[3] = v[{4, 1, 1}]; Real y = w[1] + 10*w[2] + 100*w[3]; end M;

// 10.5 end as an index; y = 934*t
model M Real v[4] = {1, 2, 3, 4}*time; Real y = v[end] + 10*v[end - 1] + 100*sum(v[2:end]); end M;

// 10.5 end in each of two dimensions; y = 634*t
model M Real a[2, 3] = [1, 2, 3; 4, 5, 6]*time; Real y = a[end, 1] + 10*a[1, end] + 100*a[end, end]; end M;

// 10.5 an index that changes; y = (5, 7, 9)[int(2 * t)]
model M Real v[3] = {5, 7, 9}; Integer i = 1 + integer(2*time); Real y = v[i]; end M;

// 10.5 an index that changes in an array of states; y = t if t < 0.5 else 5 + 2 * t
model M Real v[2](start={0, 5}, each fixed=true); Integer i = if time < 0.5 then 1 else 2; Real y = v[i]; equation
der(v) = {1, 2}; end M;

// refused: 10.5 a slice of an array of components; y = 12 * t + 50
model A parameter Real k = 1; Real z[2] = {k, 2*k}*time; end A; model M A a[3](k={1, 2, 3});
Real y = sum(a.z[2]) + 10*sum(a[2:3].k); end M;

// 10.6.1 equality of matrices as an equation; y = 31*t
model M Real a[2, 2]; Real y = a[1, 1] + 10*a[2, 1]; equation 2*a = [2, 4; 6, 8]*time; end M;

// 10.6.3 scalar, vector and matrix products; y = float([t, 1] @ A @ [t, 1]) + t * t + 1 + 2 * t
model M Real a[2, 2] = [1, 2; 3, 4]; Real v[2] = {time, 1}; Real y = v*a*v + v*v + 2*v[1]; end M;

// refused: 10.6.5 a product with a row and a column; y = 3 * t + 8
model M Real r[1, 2] = [time, 2]; Real c[2, 1] = [3; 4]; Real y = scalar(r*c); end M;

// 10.6.7 the power of a square matrix; y = float(np.linalg.matrix_power(A, 3)[0, 1] + 10 * np.linalg.matrix_power(A, 3)[1, 0] + 100)
model M parameter Real a[2, 2] = [1, 2; 3, 4]; Real b[2, 2] = a^3; Real c[2, 2] = a^0;
Real y = b[1, 2] + 10*b[2, 1] + 100*c[1, 1] + 1000*c[1, 2]; end M;

// 10.6.9 logical operators of arrays; y = 1 if t <= 0.5 else 3
model M Boolean a[2] = {time > 0.5, true}; Boolean b[2] = not a; Real y = if b[1] then 1 elseif b[2] then 2 else 3; end M;

// 10.6 a linear system in matrix form; y = float(solve(t) @ [1, 10])
model M Real x[2]; Real y = x[1] + 10*x[2]; equation ([1, 2; 3, 4] + time*identity(2))*x = {1, 2}; end M;

// 10.6 states in matrix form; y = float(np.cos(t))
model M parameter Real a[2, 2] = [0, 1; -1, 0]; Real x[2](start={1, 0}, each fixed=true); Real y = x[1]; equation
der(x) = a*x; end M;

// 10.6.2 sums of scalars and arrays by elements; y = 2 + t + 10 * (t - 1)
model M Real v[2] = {1, 2} .+ time; Real w[2] = time .- {1, 2}; Real y = v[2] + 10*w[1]; end M;

// 10.6.4 elementwise division by an array; y = (1 + t) / 2 + 30
model M Real v[2] = (1 + time) ./ {1, 2}; Real w[2] = {4, 6} ./ 2; Real y = v[2] + 10*w[2]; end M;

// 10.6.8 elementwise powers; y = 13 + 2 ** t + 800
model M Real v[2] = {2, 3} .^ 2; Real w[2] = 2 .^ {time, 3}; Real y = sum(v) + w[1] + 100*w[2]; end M;

// refused: 10.3.4 a range that depends on another iterator; y = 20*t
model M Real y = sum(sum(j*time for j in 1:i) for i in 1:4); end M;

// refused: 10.5 a slice of an array of components on the left; y = 16*t
model A Real z[2]; end A; model M A a[3]; Real y = a[3].z[2] + 10*a[1].z[1]; equation
for i in 1:2 loop a.z[i] = {1, 2, 3}*i*time; end for; end M;

// Chapters 11 and 12 of the Modelica Language Specification, 3.6: statements and functions.

// 11.1 an algorithm section runs in order; y = 2 * t + 1
model M Real y; algorithm y := time; y := 2*y; y := y + 1; end M;

// 11.1 an algorithm section with a loop; y = 6*t
model M Real y; algorithm y := 0; for i in 1:3 loop y := y + i*time; end for; end M;

// 11.1 an algorithm section with if; y = 1 if t < 0.5 else 2
model M Real y; algorithm if time < 0.5 then y := 1; else y := 2; end if; end M;

// 11.1 algorithms and equations together; y = 6 * t + 1
model M Real a; Real b; Real y; equation a = 2*time; y = b + 1; algorithm b := 3*a; end M;

// refused: 11.1.2 a discrete variable keeps its value in an algorithm; y = 0 if t < 0.5 else 3
model M Integer y(start=0, fixed=true); algorithm when time > 0.5 then y := pre(y) + 3; end when; end M;

// 11.2.1 an assignment to several variables; y = math.hypot(t, 1) + math.atan2(1, t)
model M Real r; Real phi; Real y = r + phi; algorithm (r, phi) := Shared.polar(time); end M;

// 11.2.2 for statements, nested; y = 25*t
function own input Real x; output Real y; algorithm y := 0; for i in 1:3 loop for j in 1:i loop y := y + i*j*x;
end for; end for; end own; model M Real y = own(time); end M;

// refused: 11.2.2 for statements over a vector; y = 142*t
function own input Real x; output Real y; algorithm y := 0; for w in {1, 4, 2} loop y := 10*y + w*x; end for;
end own; model M Real y = own(time); end M;

// 11.2.2 a for statement downwards; y = 321*t
function own input Real x; output Real y; algorithm y := 0; for i in 3:-1:1 loop y := 10*y + i*x; end for; end own;
model M Real y = own(time); end M;

// 11.2.2 a for statement that never runs; y = 1*t
function own input Real x; output Real y; algorithm y := x; for i in 2:1 loop y := 100; end for; end own;
model M Real y = own(time); end M;

// refused: 11.2.3 while; y = 15*t
function own input Real x; output Real y; protected Integer n; algorithm n := 0; y := 0; while n < 5 loop
n := n + 1; y := y + n*x; end while; end own; model M Real y = own(time); end M;

// refused: 11.2.3 while with a condition on the argument; y = (lambda r: r if r > 0 else 0.3)(1 + t - 0.3 * math.floor((1 + t) / 0.3))
function own input Real x; output Real y; algorithm y := x + 1; while y > 0.3 loop y := y - 0.3; end while; end own;
model M Real y = own(time); end M;

// refused: 11.2.4 break leaves the innermost loop; y = 6*t
function own input Real x; output Real y; algorithm y := 0; for i in 1:3 loop for j in 1:5 loop if j > i then break;
end if; y := y + x; end for; end for; end own; model M Real y = own(time); end M;

// refused: 11.2.5 return leaves the function; y = 1 + 3 * t
function own input Real x; output Real y; algorithm y := 1; for i in 1:5 loop y := y + x; if i == 3 then return;
end if; end for; y := 100; end own; model M Real y = own(time); end M;

// 11.2.6 if statements; y = 1 if t > 0.7 else t if t > 0.4 else 2 * t if t > 0.2 else 7
function own input Real x; output Real y; algorithm y := 7; if x > 0.7 then y := 1; elseif x > 0.4 then y := x;
elseif x > 0.2 then y := 2*x; end if; end own; model M Real y = own(time); end M;

// 11.2.6 an if statement that assigns a part of an array; y = (10 * t if t > 0.5 else 2) + 3
function own input Real x; output Real y[3]; algorithm y := {1, 2, 3}; if x > 0.5 then y[2] := 10*x; end if; end own;
model M Real z[3] = own(time); Real y = z[2] + z[3]; end M;

// 11.2.8 an assertion in an algorithm; y = 1*t
model M Real y = time; algorithm assert(time < 2, "time is too large"); end M;

// 12.1 a function with a binding of a local variable; y = 2 * t * (2 * t + 1)
function own input Real x; output Real y; protected Real a = 2*x; Real b = a + 1; algorithm y := a*b; end own;
model M Real y = own(time); end M;

// 12.1 a function whose output has a default; y = 3*t
function own input Real x; output Real y = 3*x; algorithm end own; model M Real y = own(time); end M;

// 12.2 a pure function is evaluated where it is called; y = 3 * t + 1 + 60
function own input Real x[2]; input Real k; output Real y[2]; algorithm y := k*x; y[1] := y[1] + 1; end own;
model M Real z[2] = own({time, 2}, 3); Real y = z[1] + 10*z[2]; end M;

// 12.4 a function in an equation of its inverse; y = math.sqrt(4 + t)
model M Real x(start=1); Real y = x; equation Shared.square(x) = 4 + time; end M;

// 12.4.1 defaults that use other inputs; y = 3 * t + 100 * (t + 1)
function own input Real x; input Real k = 2*x; output Real y; algorithm y := x + k; end own;
model M Real y = own(time) + 100*own(time, 1); end M;

// 12.4.2 functions as arguments; y = t * t + 1
function own input Shared.law f; input Real x; output Real y; algorithm y := f(x) + 1; end own;
model M Real y = own(function Shared.square(), time); end M;

// 12.4.3 three results, two of them used; y = 31*t
function own input Real x; output Real a; output Real b; output Real c; algorithm a := x; b := 2*x; c := 3*x; end own;
model M Real a; Real c; Real y = a + 10*c; equation (a, , c) = own(time); end M;

// 12.4.4 a function of a matrix whose sizes depend on the argument; y = 43*t
function own input Real a[:, :]; output Real y[size(a, 2), size(a, 1)]; algorithm for i in 1:size(a, 1) loop
for j in 1:size(a, 2) loop y[j, i] := a[i, j]; end for; end for; end own;
model M Real z[3, 2] = own([1, 2, 3; 4, 5, 6]*time); Real y = z[3, 1] + 10*z[1, 2]; end M;

// 12.4.6 a scalar function of a vector; y = 13*t
function own input Real x; input Real k; output Real y; algorithm y := k*x; end own;
model M Real z[3] = own({1, 2, 3}, time); Real y = z[3] + 10*z[1]; end M;

// 5.3.2 a leading dot means the built-in function; y = math.asin(t/2) + math.atan2(t, 2); z = math.sin(t)
package own partial function Icon end Icon; function asin extends Icon; input Real u; output Real y;
algorithm y := .asin(u); annotation(Inline=true); end asin;
function atan2 input Real a; input Real b; output Real y; algorithm y := .atan2(a, b); end atan2;
function sin input Real u; output Real y; algorithm y := .sin(u); end sin;
function both input Real u; output Real y; algorithm y := asin(u/2) + atan2(u, 2); end both; end own;
model M Real y = own.both(time); Real z = own.sin(time); end M;

// 12.5 built-in functions in functions; y = math.sqrt(abs(t - 0.5)) + max(t, 0.3) + t + 1
function own input Real x; output Real y; algorithm y := sqrt(abs(x - 0.5)) + max({x, 0.3}) + sum({x, 1}); end own;
model M Real y = own(time); end M;

// refused: 12.6 a record as argument and result; y = 5 + 20 * t
function own input Shared.Pair p; output Shared.Pair q; algorithm q.a := p.b; q.b := 2*p.a; end own;
model M Shared.Pair p; Shared.Pair q = own(p); Real y = q.a + 10*q.b; equation p.a = time; p.b = 5; end M;

// 12.6 a record constructor with defaults; y = t + 720
record R Real a; Real b = 2; Real c = 3; end R; model M R r = R(time, c=7); Real y = r.a + 10*r.b + 100*r.c; end M;

// 12.6 a constructor of a derived record; y = t + 50
record R Real a; Real b = 2; end R; record S = R(b=5); model M S s = S(a=time); Real y = s.a + 10*s.b; end M;

// 12.7.1 an annotation of the derivative; y = 3 * t * t
function own input Real x; output Real y; algorithm y := x^3; annotation(derivative=ownder); end own;
function ownder input Real x; input Real dx; output Real dy; algorithm dy := 3*x^2*dx; end ownder;
model M Real z = own(time); Real y = der(z); end M;

// refused: 12 recursion; y = 55
function own input Integer n; output Integer y; algorithm y := if n <= 1 then n else own(n - 1) + own(n - 2); end own;
model M Real y = own(10); end M;

// 12 an Integer function; y = math.floor(10 * t) // 2 + math.floor(10 * t) % 3
function own input Integer n; output Integer y; algorithm y := div(n, 2) + mod(n, 3); end own;
model M Integer k = integer(10*time); Real y = own(k); end M;

// 12 a Boolean function; y = 0 if t < 0.5 else 1
function own input Real x; input Boolean b; output Boolean y; algorithm y := b and x > 0.5; end own;
model M Real y = if own(time, true) then 1 else 0; end M;

// 12 a function of an enumeration; y = 2.5 if t < 0.5 else 4
function own input Shared.Gear g; output Real y; algorithm y := if g == Shared.Gear.low then 1 elseif
g == Shared.Gear.middle then 2.5 else 4; end own;
model M Shared.Gear g = if time < 0.5 then Shared.Gear.middle else Shared.Gear.high; Real y = own(g); end M;

// 12 a table that a function interpolates; y = 1 + 2 * min(max((t - 0.2) / 0.3, 0), 1) - min(max((t - 0.5) / 0.3, 0), 1)
function own input Real x; input Real xs[:]; input Real ys[size(xs, 1)]; output Real y; algorithm y := ys[1];
for i in 1:size(xs, 1) - 1 loop y := y + (ys[i + 1] - ys[i])*min(max((x - xs[i])/(xs[i + 1] - xs[i]), 0), 1);
end for; end own; model M Real y = own(time, {0.2, 0.5, 0.8}, {1, 3, 2}); end M;

// refused: 14 operator records; y = 2 * t + 1
operator record V Real a; encapsulated operator function '+' input V p; input V q; output V r;
algorithm r := V(p.a + q.a + 1); end '+'; end V; model M V p = V(time); V q = p + p; Real y = q.a; end M;

// refused: 16 a clock; y = 0.2 * math.floor(10 * t + 1e-09)
model M Real x = 2*time; Real z = sample(x, Clock(0.1)); Real y = hold(z); end M;

// refused: 17 a state machine; y = 1
model M block A outer output Integer n(start=0); equation n = previous(n) + 1; end A; inner Integer n(start=0); A a;
Real y = n; equation initialState(a); end M;

// 18 annotations of evaluation and inlining; y = 6*t
function own input Real x; output Real y; algorithm y := 2*x; annotation(Inline=true); end own;
model M parameter Real k = 3 annotation(Evaluate=true); Real y = k*own(time); end M;

// 2 comments and quoted names; y = 2*t
model M /* a comment // in a comment */ Real 'a b' = time; // the rest; of a line
Real y = 2*'a b' "text with \"quotes\""; end M;

// 6 a record of another name with the same fields; y = math.hypot(t, 2)
record R Real a; Real b; end R; model M R r = R(time, 2); Real y = Shared.norm(Shared.Pair(r.a, r.b)); end M;

// 8.3.2 columns in a loop; m[1,1] = 1*t; m[1,2] = 2*t; m[2,1] = 2*t; m[2,2] = 4*t; m[3,1] = 3*t; m[3,2] = 6*t
model M Real m[3, 2]; equation for k in 1:2 loop m[:, k] = {time, 2*time, 3*time}*k; end for; end M;

// 8.3.2 rows in a loop; m[1,1] = 1*t; m[1,2] = 2*t; m[2,1] = 2*t; m[2,2] = 4*t; m[3,1] = 3*t; m[3,2] = 6*t
model M Real m[3, 2]; equation for i in 1:3 loop m[i, :] = {time, 2*time}*i; end for; end M;

// 8.3.2 slices downwards in a loop downwards; m[1,1] = 9; m[1,2] = 18; m[2,1] = 7; m[2,2] = 14; m[3,1] = 5; m[3,2] = 10
model M Real m[3, 2]; equation for k in 2:-1:1 loop m[3:-1:1, k] = {5, 7, 9}*k; end for; end M;

// 8.3.2 a list as an index in a loop; m[1,1] = 7; m[1,2] = 14; m[2,1] = 9; m[2,2] = 18; m[3,1] = 5; m[3,2] = 10
model M Real m[3, 2]; equation for k in 1:2 loop m[{3, 1, 2}, k] = {5, 7, 9}*k; end for; end M;

// 8.3.2 a slice and an element in a loop; m[1,1] = 1; m[1,2] = 2; m[2,1] = 5; m[2,2] = 10; m[3,1] = 7; m[3,2] = 14
model M Real m[3, 2]; equation for k in 1:2 loop m[2:3, k] = {5, 7}*k; m[1, k] = k; end for; end M;

// 8.3.2 a slice in a loop that never runs; m[1,1] = 4; m[1,2] = 4; m[2,1] = 4; m[2,2] = 4; m[3,1] = 4; m[3,2] = 4
model M Real m[3, 2]; equation for k in 1:0 loop m[:, k] = {5, 7, 9}; end for; m = fill(4, 3, 2); end M;

// 8.3.2 slices of one dimension of three; m[1,1] = 1; m[1,2] = 2; m[2,1] = 2; m[2,2] = 4; m[3,1] = 3; m[3,2] = 6
model M Real m[3, 2]; Real v[1, 3, 2]; equation for j in 1:1, k in 1:2 loop v[j, :, k] = {1, 2, 3}*k; end for; m = v[1, :, :]; end M;

// 8.3.2 slices of two dimensions of three; m[1,1] = 1; m[1,2] = 2; m[2,1] = 2; m[2,2] = 4; m[3,1] = 3; m[3,2] = 6
model M Real m[3, 2]; Real v[1, 3, 2]; equation for i in 1:3 loop v[:, i, :] = {{1, 2}}*i; end for; m = v[1, :, :]; end M;

// 8.3.2 derivatives of columns; m[1,1] = 5*t; m[1,2] = 10*t; m[2,1] = 7*t; m[2,2] = 14*t; m[3,1] = 9*t; m[3,2] = 18*t
model M Real m[3, 2](each start=0, each fixed=true); equation for k in 1:2 loop der(m[:, k]) = {5, 7, 9}*k; end for; end M;

// 11.2.2 a for statement over two ranges; y = 123246*t
function own input Real x; output Real y; algorithm y := 0; for i in 1:2, j in 1:3 loop y := 10*y + i*j*x; end for; end own;
model M Real y = own(time); end M;

// 12.4.4 a local array whose size is that of the argument; y = t * t + 13
function own input Real v[:]; output Real y; protected Real w[size(v, 1)]; algorithm y := 0; for i in 1:size(v, 1) loop
w[i] := v[i]^2; y := y + w[i]; end for; end own; model M Real y = own({time, 2, 3}); end M;

// 11.2.1 assignments to slices; y = 678 + 1000 * t
function own input Real v[:]; output Real y; protected Real w[2, 3]; algorithm w := zeros(2, 3); w[1, :] := v;
w[:, {3, 1}] := {{7, 8}, {5, 6}}; y := w[1, 1] + 10*w[1, 3] + 100*w[2, 1] + 1000*w[1, 2]; end own;
model M Real y = own({1, time, 3}); end M;

// 10.5 an index that changes in a function; y = 1 if t < 0.5 else 5
function own input Real x; input Real v[:]; output Real y; algorithm y := v[integer(x)]; end own;
model M Real y = own(1.5 + time, {1, 5, 7}); end M;

// 10.5 an assignment at an index that changes; y = 400 if t < 0.5 else 54
function own input Real x; output Real y; protected Real a[2, 3]; algorithm a := zeros(2, 3); a[integer(x), 3] := 4;
a[2, integer(x)] := 5; y := a[2, 3] + 10*a[2, 2] + 100*a[1, 3]; end own; model M Real y = own(1.5 + time); end M;

// 11.2.5 return from a branch; y = 2 if t > 0.5 else 3
function own input Real x; output Real y; algorithm y := 1; if x > 0.5 then y := 2; return; end if; y := 3; end own;
model M Real y = own(time); end M;

// 11.2.2 a result that only a loop assigns; y = 3*t
function own input Real x; output Real y; algorithm for i in 1:3 loop y := i*x; end for; end own; model M Real y = own(time); end M;

// 11.2.2 a local variable that only a loop assigns; y = 6*t
function own input Real x; output Real y; protected Real z; algorithm y := 0; for i in 1:3 loop z := i*x; y := y + z; end for;
end own; model M Real y = own(time); end M;

// 3.5 equality of Reals in a function; y = 1 + t
function own input Real x; output Real y; algorithm if x == 2 then y := 1; else y := 0; end if; end own;
model M parameter Real p = 2; Real y = own(p) + time; end M;

// 11.1.2 a variable that is read first has its start value; y = 1 + t; z = 1*t
model M Real y; Real z; algorithm y := z + 1; z := time; y := y + z; end M;

// 11.2.2 a loop over Real numbers; y = 5*t
model M Real y; algorithm y := 0; for r in 0.5:0.5:2 loop y := y + r*time; end for; end M;

// 11.2.2 a loop of an algorithm without repetitions; y = 1
model M Real y; algorithm y := 1; for i in 2:1 loop y := 7; end for; end M;

// 11.2.2 nested loops over a range that depends on the outer one; y = 112123
model M Real y; algorithm y := 0; for i in 1:3 loop for j in 1:i loop y := 10*y + j; end for; end for; end M;

// 11.2.1 elements of an array; x[1] = 5; x[2] = 2; x[3] = 1
model M Real x[3]; algorithm for i in 1:3 loop x[4 - i] := i; end for; x[1] := x[1] + x[2]; end M;

// 11.2.1 an array as a whole; x[1] = 1; x[2] = 1*t; s = 1 + 2 * t
model M Real x[2]; Real s; algorithm x := {1, time}; s := sum(x) + x[2]; end M;

// 11.2.2 a loop to an Integer parameter; x[1] = 1; x[2] = 1 + t; x[3] = 1 + 2 * t
model M parameter Integer n = 3 "size"; Real x[n]; algorithm x[1] := 1; for i in 2:n loop
x[i] := x[i - 1] + time; end for; end M;

// 11.2.2 an iterator with the name of a constant; x[1] = 2; x[2] = 4; x[3] = 6
model M constant Integer j = 3; Real x[j]; algorithm for j in 1:j loop x[j] := 2*j; end for; end M;

// 11.2.6 no branch; y = 6
model M Real y; algorithm y := 5; if noEvent(time > 2) then y := 1; end if; y := y + 1; end M;

// 11.2.6 a condition on a variable that its branch changes; y = 0 if t > 0 else 9
model M Real y; algorithm y := time; if noEvent(y > 0) then y := 0; elseif noEvent(y < 1) then y := 9; end if; end M;

// 11.2.2 an iteration; y = (2 + t) ** 0.5
model M Real y; algorithm y := 4; for i in 1:6 loop y := y - (y*y - 2 - time)/(2*y) + 0*(y + y + y + y); end for; end M;

// 11.2.1 an assignment to two variables that read each other; p = 3 + t; q = 6 + 2 * t; r = 9 + 3 * t
function own input Real u; output Real a; output Real b; algorithm a := u; b := 2*u; end own;
model M Real p; Real q; Real r; algorithm p := 3; r := p; (p, q) := own(r + time); r := p + q; end M;

// 8.3.2 a for equation with one of two ranges; x[1,1] = 11; x[1,2] = 12; x[2,1] = 21; x[2,2] = 22
model M Real x[2, 2]; equation for i in 1:2, j loop x[i, j] = 10*i + j; end for; end M;

// 10.3.4 a reduction over a list; y = 5
model M Real y = max(abs(i - 4) for i in {3, 9, 4}); end M;

// 10.3.4 a reduction in a for equation; x[1] = 3*t; x[2] = 6*t
model M Real v[2] = {1, 2}*time; Real x[2]; equation for k loop x[k] = k*sum(v[i] for i); end for; end M;

// 10.3.4 reductions over an iterator without values; s = 0; p = 1
model M parameter Integer n = 0; Real s = sum(1.0 + i for i in 1:n); Real p = product(1.0 + i for i in 1:n); end M;

// 10.3.4 extremes of an iterator without values; a = np.finfo(float).max; b = np.finfo(float).min; tolerance = 0
model M parameter Integer n = 0; Real a = min(1.0 + i for i in 1:n); Real b = max(1.0 + i for i in 1:n); end M;
