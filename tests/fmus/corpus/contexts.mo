// Places in a class where an expression may be. `SIGNAL`, `SIGNAL_OF`, `VALUE` and `E` are those of contexts.py.

// equation; signal
model M Real x; Real y; equation x = SIGNAL; y = E(x); end M;

// equation the other way round; signal
model M Real x; Real y; equation E(x) = y; SIGNAL = x; end M;

// binding; signal
model M Real x = SIGNAL; output Real y = E(x); end M;

// protected variable; signal
model M Real x = SIGNAL; Real y = z; protected Real z = E(x); end M;

// state; integrated; tolerance = 0.0001
model M Real x = SIGNAL; Real y(start=0, fixed=true); equation der(y) = E(x); end M;

// of a state; signal
model M Real s(start=0, fixed=true); Real x; Real y; equation der(s) = 1; x = SIGNAL_OF(s); y = E(x); end M;

// derivative; differentiated; smooth; tolerance = 0.0001
model M Real x = SIGNAL; Real z = E(x); Real y = der(z); end M;

// parameter; parameter
model M parameter Real p = VALUE; parameter Real q = E(p); Real y = q; end M;

// final parameter; parameter
model M parameter Real p = VALUE; final parameter Real q = E(p); Real y = q; end M;

// constant; parameter
model M constant Real p = VALUE; constant Real q = E(p); Real y = q; end M;

// constant of a package; parameter
package own constant Real p = VALUE; constant Real q = E(p); end own; model M Real y = own.q; end M;

// start value; parameter_and_time
model M parameter Real p = VALUE; Real y(start=E(p), fixed=true); equation der(y) = 1; end M;

// initial equation; initial_and_time
model M Real x = SIGNAL; Real y; initial equation y = E(x); equation der(y) = 1; end M;

// initial algorithm; initial_and_time
model M Real x = SIGNAL; Real y; initial algorithm y := E(x); equation der(y) = 1; end M;

// when clause; sampled
model M Real x = SIGNAL; discrete Real y(start=0, fixed=true); equation
when sample(0.1, 0.2) then y = E(x); end when; end M;

// reinit; sampled
model M Real x = SIGNAL; Real y(start=0, fixed=true); equation der(y) = 0;
when sample(0.1, 0.2) then reinit(y, E(x)); end when; end M;

// algorithm; signal
model M Real x = SIGNAL; Real y; Real z; algorithm z := E(x); y := z; y := y + z; y := y/2; end M;

// when clause in an algorithm; sampled
model M Real x = SIGNAL; discrete Real y(start=0, fixed=true); algorithm
when sample(0.1, 0.2) then y := E(x); end when; end M;

// function body; signal
function own input Real x; output Real y; algorithm y := E(x); end own;
model M Real x = SIGNAL; Real y = own(x); end M;

// protected variable of a function; signal
function own input Real x; output Real y; protected Real z = 2*x; Real w; algorithm w := z - x; y := E(w);
end own; model M Real x = SIGNAL; Real y = own(x); end M;

// loop of a function; signal
function own input Real x; output Real y; algorithm y := 0; for n in 1:3 loop y := y + n*(E(x)); end for;
end own; model M Real x = SIGNAL; Real y = own(x)/6; end M;

// argument of a function; signal
model M Real x = SIGNAL; Real y = Shared.double(E(x))/2; end M;

// element of an array; signal
model M Real x[3]; Real z[3]; Real y = z[2]; equation x = {0, SIGNAL, 0}; z[1] = 1; z[2] = E(x[2]); z[3] = 2; end M;

// array constructor; signal
model M Real x = SIGNAL; Real z[3] = {1, E(x), 2}; Real y = z[2]; end M;

// for equation; signal
model M Real x[2]; Real z[2]; Real y = z[2]; equation x = {VALUE, SIGNAL};
for n in 1:2 loop z[n] = E(x[n]); end for; end M;

// body of an array over an iterator; signal
model M Real x[2] = {VALUE, SIGNAL}; Real z[2] = {E(x[n]) for n in 1:2}; Real y = z[2]; end M;

// body of a sum over an iterator; signal
model M Real x = SIGNAL; Real y = sum(n*(E(x)) for n in 1:2)/3; end M;

// if expression; branches
model M Real x = SIGNAL; Real y = if time < 0.55 then E(x) else 1 - (E(x)); end M;

// if equation; branches
model M Real x = SIGNAL; Real y; equation if time < 0.55 then y = E(x); else y = 1 - (E(x)); end if; end M;

// if equation of a parameter; signal
model M parameter Boolean b = true; Real x = SIGNAL; Real y; equation if b then y = E(x); else y = 1; end if; end M;

// inherited; signal
model B Real x = SIGNAL; Real y = E(x); end B; model M extends B; end M;

// inherited through two levels; signal
model A Real x; Real y; end A; model B extends A; equation y = E(x); end B;
model M extends B(x=SIGNAL); end M;

// component; signal
model A input Real x; Real y = E(x); end A; model B A a(x=SIGNAL); Real y = a.y; end B;
model M B b; Real y = b.y; end M;

// array of components; signal
model A input Real x; Real y = E(x); end A; model M A a[2](x={VALUE, SIGNAL}); Real y = a[2].y; end M;

// redeclared component; signal
partial model L input Real x; output Real y; end L; model A extends L; equation y = 0; end A;
model C extends L; equation y = E(x); end C;
model B replaceable A a constrainedby L; Real x = SIGNAL; equation a.x = x; end B;
model M B b(redeclare C a); Real y = b.a.y; end M;

// redeclared class; signal
partial model L input Real x; output Real y; end L; model A extends L; equation y = 0; end A;
model C extends L; equation y = E(x); end C;
model B replaceable model K = A constrainedby L; K a; Real x = SIGNAL; equation a.x = x; end B;
model M B b(redeclare model K = C); Real y = b.a.y; end M;

// redeclared function; signal
function own extends Shared.law; algorithm y := E(x); end own;
model B replaceable function f = Shared.square constrainedby Shared.law; Real x = SIGNAL; Real y = f(x); end B;
model M extends B(redeclare function f = own); end M;

// modifier; parameter
model A parameter Real q = 1; end A; model M parameter Real p = VALUE; A a(q=E(p)); Real y = a.q; end M;

// modifier of an extends clause; parameter
model A parameter Real q = 1; Real y = q; end A; model M parameter Real p = VALUE; extends A(q=E(p)); end M;

// record constructor; signal
model M Real x = SIGNAL; Shared.Pair r = Shared.Pair(1, E(x)); Real y = r.b; end M;

// field of a record; signal
model M Shared.Pair r; Shared.Pair s; Real y = s.b; equation r.a = SIGNAL; r.b = 1; s.a = 0; s.b = E(r.a); end M;

// connector; signal
connector In = input Real; connector Out = output Real;
block A In x; Out y; equation y = E(x); end A; block S Out y; equation y = SIGNAL; end S;
model M S s; A a; Real y = a.y; equation connect(s.y, a.x); end M;

// physical connector; signal
connector F Real e; flow Real f; end F;
model A F p; Real x = SIGNAL; equation p.f = -(E(x)); end A;
model R F p; Real e = p.e; equation p.e = 2*p.f; end R;
model M A a; R r1; R r2; Real y = r1.e + r2.p.f - r2.p.f; equation connect(a.p, r1.p); connect(r1.p, r2.p); end M;

// inner variable; signal
model A outer Real x; Real y = E(x); end A; model M inner Real x = SIGNAL; A a; Real y = a.y; end M;

// linear loop; signal
model M Real x = SIGNAL; Real y; Real z; equation y + z = 3*(E(x)); y - z = -(E(x)); end M;

// nonlinear loop; solved
model M Real x = SIGNAL; Real y(start=1); equation y + y^3/3 = E(x); end M;

// condition; condition
model M Real x = SIGNAL; Real y = if (E(x)) > THRESHOLD then 1 else 0; end M;

// condition of a when clause; counted
model M Real x = SIGNAL; Integer y(start=0, fixed=true); equation
when (E(x)) > THRESHOLD then y = pre(y) + 1; end when; end M;
