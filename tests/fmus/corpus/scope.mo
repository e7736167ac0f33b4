// Bodies of classes of the package P of Scope.mo, each with the value of its variable y.

// 5.3: name lookup

// a constant of the package around; 2
Real y = k;

// an element hides one of the package around; 4
constant Real k = 4; Real y = k;

// an inherited element hides one of the package around; 7
extends Holder; Real y = k;

// a composite name; 5
Real y = P.k + P.size3;

// a global name; 2
constant Real k = 4; Real y = .P.k;

// a class of a class; 8
model Z Real v = 8; end Z; Z z; Real y = z.v;

// a qualified import; 3
import P.size3; Real y = size3;

// a renamed import; 2
import Q = P; Real y = Q.k;

// an unqualified import; 3
import P.*; Real y = size3;

// a default that uses a constant; 6
Real y = scaled(3);

// named arguments in any order; 12
Real y = scaled(factor=4, u=3);

// 4.5.1, 5.3: the modifiers of a short class are those of the class around it

// a short class with a parameter; 6
parameter Real p = 6; model Z = A(q=p); Z z; Real y = z.q;

// a short class of a short class; 6
parameter Real p = 6; model Z = A(q=p); model V = Z; V z; Real y = z.q;

// a short class modified again; 8
model Z = A(q=6); Z z(q=8); Real y = z.q;

// 4.9: types

// a derived type; 3
parameter Distance p = 3; Real y = p;

// a start value of a derived type; 30
Fast v(fixed=true); Real y = v - time; equation der(v) = 1;

// a start value of the first type; 7
type S = Speed(min=0); S v(fixed=true); Real y = v - time; equation der(v) = 1;

// a start value of the type between; 3
type S = Speed(start=3); type D = S(min=0); D v(fixed=true); Real y = v - time; equation der(v) = 1;

// a derived type of a vector; 7
type V = Speed[2](each min=0); V v(each fixed=true); Real y = v[2] - time; equation der(v) = {1, 1};

// an enumeration; 3
parameter Level p = Level.high; Real y = if p == Level.high then Integer(p) else 0;

// enumerations in order; 1
parameter Level p = Level.low; Real y = if p < Level.middle then 1 else 0;

// 5.4: inner and outer

// an outer model; 12
inner World world(g=4); Falling f; Real y = f.y;

// the nearest inner; 1203
model Z inner World world(g=1); Falling f; end Z; inner World world(g=4); Z z; Falling f; Real y = z.f.y + 100*f.y;

// outer variables; 216
inner Integer n = 10; inner Boolean on = time >= 0.5; inner parameter Real m = 2; inner parameter Level level =
Level.high; inner Integer list[2] = {1, 200}; Counter c; Real y = c.y;

// outer variables from outside; 17
inner Integer n = 10; inner Boolean on = time >= 0.5; inner parameter Real m = 2; inner parameter Level level =
Level.high; inner Integer list[2] = {1, 200}; Counter c[2]; Real y = c[2].n + c[1].m + Integer(c[1].level) + (if
c[1].on then 1 else 0) + c[2].list[1]; equation assert(c[1].n == 10 and c[2].list[2] == 200 and c[1].level ==
Level.high, "n");

// 7.1: inheritance

// a modifier of a base; 15
extends A(q=4, v={5, 6}); Real z = y;

// a modifier over that of a base; 9
B b(q=6); Real y = b.y;

// the modifier of a base; 8
B b; Real y = b.y;

// a base by two ways; 4
model D1 extends R2; end D1; model D2 extends R2; end D2; model R2 parameter Real p = 4; end R2; model D extends D1;
extends D2; end D; D d; Real y = d.p;

// a protected base; 4
model Z protected extends A(q=1); public Real z = y; end Z; Z z; Real y = z.z;

// 7.2: modification

// nested modifiers; 50
Holder h(law(r=5)); Real y = h.law.y;

// each element; 8
A a[2](each q=1); Real y = a[1].y + a[2].y;

// one for each element; 5
A a[2](q={1, 2}); Real y = a[2].y;

// a modifier of an array in an array; 10
A a[2](v={{1, 2}, {3, 4}}); Real y = a[2].y;

// a modifier by a parameter of the class; 9
parameter Real q = 9; A a(q=q); Real y = a.q;

// the record of a record; 33
R3 r(a=10); Real y = r.a + r.b + r.c;

// a record constructor; 11
R r = R(5, b=6); Real y = r.a + r.b;

// 7.3: redeclaration

// a redeclared component; 49
Holder h(redeclare Square law); Real y = h.law.y;

// a redeclared component with a modifier; 4
Holder h(redeclare Square law(r=2)); Real y = h.law.y;

// a redeclared component of a base; 49
extends Holder(redeclare Square law); Real y = law.y;

// a redeclared class; 16
Chooser c(redeclare model L = Square); Real y = c.law.y;

// a class that is not redeclared; 40
Chooser c; Real y = c.law.y;

// a redeclared element with a value; 6
model Z replaceable parameter Real p = 1; Real z = p; end Z; model V extends Z; redeclare parameter Real p(min=0) = 6;
end V; V v; Real y = v.z;

// 4.4.5: conditional components

// a component that is left out; 12
model Z parameter Boolean on = true; Source s if on; Source t(k=1) if not on; Gain g; equation connect(s.y, g.u);
connect(t.y, g.u); end Z; Z a; Z b(on=false); Real y = a.g.y + b.g.y;

// 4.4.4, 8.3.4: variability

// parameters in any order; 6
parameter Real a = b; parameter Real b = 2*d; parameter Real d = 3; Real y = a;

// an if equation of a parameter with an assertion; 1
parameter Boolean check = true; Real y; equation if check then y = 1; assert(y > 0, "y"); else y = 2; end if;

// 9: connections

// forces in a connection; 3
Wall wall; Spring s; Force f; equation connect(wall.c, s.a); connect(s.b, f.c); public Real y = s.b.s;

// three connectors; 1.5
Wall wall; Spring s[2]; Force f; equation for i in 1:2 loop connect(wall.c, s[i].a); connect(s[i].b, f.c); end for;
public Real y = f.c.s;

// arrays of connectors; 13
model Z Flange c[2]; equation c.s = {1, 2}; end Z; model V Flange c[2]; Real t = sum(c.f); equation c[1].f = 3*c[1].s;
c[2].f = 5*c[2].s; end V; Z z; V v; equation connect(z.c, v.c); public Real y = v.t;

// an open connector; 4
Wall wall; Spring s; equation connect(wall.c, s.a); public Real y = 4 + s.b.s;

// signals; 15
Source s; Gain g(k=3); equation connect(s.y, g.u); public Real y = g.y;

// a connector outside; 3
model Z Flange a; Spring s; Wall w; equation connect(a, s.a); connect(s.b, w.c); end Z; Z z; Force f; equation
connect(z.a, f.c); public Real y = z.a.s;
