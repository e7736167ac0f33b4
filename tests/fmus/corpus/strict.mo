// Classes of the package P of tests/fmus/test_strict_modelica.py: `X` is read, after what stands before it.

// lenient: a function with the name of a built-in one; P\.sin has the name of a built-in one
function sin input Real u; output Real y; algorithm y := 2*u; end sin; model X Real y = sin(0.5); end X;

// lenient: a function with the name of a built-in one that calls another; P\.sin has the name of a built-in one
function sin input Real u; output Real y; algorithm y := .cos(u); end sin; model X Real y = sin(0.5); end X;

// lenient: a function with the name of a built-in one that changes its value; P\.sin has the name of a built-in one
function sin input Real u; output Real y; algorithm y := .sin(u); y := y + 1; end sin; model X Real y = sin(0.5); end X;

// lenient: a function with the name of a built-in one and other arguments; P\.atan2 has the name of a built-in one
function atan2 input Real u; input Real v; output Real y; algorithm y := .atan2(v, u); end atan2;
model X Real y = atan2(0.5, 1); end X;

// lenient: an import with the name of a built-in function; the import exp has the name of a built-in function
function double input Real u; output Real y; algorithm y := 2*u; end double; model X import exp = P.double; Real y =
exp(0.5); end X;

// lenient: a modifier outside the constraining clause; 'r' is modified on the declaration
model X Lost n(redeclare B a); end X;

// lenient: a modifier that the clause has otherwise; 'r' is modified on the declaration
model Y replaceable A a[2](each r=7) constrainedby Law(r=8); end Y; model X Y y(redeclare B a); end X;

// lenient: a constraining clause that is not redeclared; modifiers of its constraining clause, r \(
model X Kept n; end X;

// lenient: a constraining clause that is only modified; does not redeclare 'a' of P\.Kept
model X Kept n(a(q=1)); end X;

// lenient: a constraining clause of a class; constraining clause of the class M are lost
model Y replaceable model M = A constrainedby Law(r=3); M m; end Y; model X Y y; end X;

// lenient: a redeclared class with modifiers; 'MR' would lose the modifiers
model X N n(redeclare model MR = E); end X;

// lenient: modifiers of the new class; that replaces 'M' are lost
model X N n(redeclare model M = B(q=2)); end X;

// lenient: the same in a base; that replaces 'M' are lost
model X extends N(redeclare model M = B(q=2)); end X;

// lenient: a redeclaration by an element; redeclare it in the extends clause
model X extends Kept; redeclare B a; end X;

// lenient: a redeclaration inside modifiers; 'plain' inside the modifiers
model Y N n; end Y; model X Y y(n(redeclare B plain)); end X;

// lenient: a redeclared class inside modifiers; 'M' inside the modifiers
model Y N n; end Y; model X Y y(n(redeclare model M = B)); end X;

// lenient: a redeclaration inside modifiers of a base; 'plain' inside the modifiers
model Y N n; end Y; model X extends Y(n(redeclare B plain)); end X;

// lenient: a final class; P\.Y\.F, which is final
model Y final model F = A; F f(q=2); end Y; model X Y y; end X;

// lenient: an unknown element of a component; 'zz' is modified, which P\.A does not have
model X N n(n(zz=1)); end X;

// lenient: an unknown element of a base; 'zz' is modified, which P\.A does not have
model X extends A(zz=1); end X;

// lenient: an unknown attribute; 'zz' is not an attribute of q
model X A a(q(zz=1)); end X;

// lenient: an unknown attribute in a type; 'unt' is not an attribute of Distance
type Length = Real(start=2, unit="m"); type Distance = Length(unt=1, min=0); model X Distance x(fixed=true); equation
der(x) = 1; end X;

// lenient: an unknown element of the new type; 'v' is modified, which P\.B
model X N n(redeclare B plain(v={1, 2})); end X;

// lenient: an unknown element of the constraint; clause of a modifies 'q', which P\.Law does not have
model Y replaceable A a constrainedby Law(q=1); end Y; model X Y y(redeclare A a); end X;

// lenient: a protected element; 'hidden' is modified, which is protected in P\.A
model X A a(hidden=1); end X;

// lenient: a protected component; 'pa' is modified, which is protected
model X N n(pa(q=1)); end X;

// lenient: a protected element redeclared; 'pra' is modified, which is protected
model X N n(redeclare A pra); end X;

// lenient: no each on a component; 'q' is given a scalar .* write `each`
model X A a[2](q=1); end X;

// lenient: no each below a component; 'q' is given a scalar .* write `each`
model X N n(arr(q=1)); end X;

// lenient: no each on an attribute; 'start' is given a scalar .* write `each`
model X Real x[2](start=1) = {1, 2}; end X;

// lenient: no each on a parameter's attribute; 'start' is given a scalar .* write `each`
model X A a(v(start=1)); end X;

// lenient: each of an array; 'start' is given a vector where 0
model X Real x[2](each start={1, 2}) = {1, 2}; end X;

// lenient: a modifier twice, by name and nested; 'q\.start' is modified twice
model X A a(q.start=1, q(start=2)); end X;

// lenient: a modifier twice on a base; 'q' is modified twice
model X extends A(q=1, q=2); end X;

// lenient: a part of a record with a value; a part of 'whole' is modified
model X N n(whole(a=9)); end X;

// lenient: an inherited element again; q is inherited from P\.A and declared again
model X extends A; parameter Real q = 1; end X;

// lenient: a redeclaration of what is not inherited; P\.X does not inherit it
model X redeclare A a; end X;

// lenient: a redeclaration by an element, not replaceable; n is redeclared, but is not replaceable
model X extends N; redeclare E n; end X;

// lenient: a redeclaration by an element, of no subtype; plain is of P\.Other, which lacks r of P\.Law
model X extends N; redeclare Other plain; end X;

// lenient: two modifiers with dotted names; the modifier of 'n\.k' would be lost .*n\(k = \.\.\.\)
model Y N n; end Y; model X Y y(n.k=1, n.c=2); end X;

// lenient: a final modifier with a dotted name; write nested brackets: q\(start
model X A a(final q.start=1); end X;

// lenient: constants of a package and its heir; P\.H modifies constants of P\.K, which is used itself
package K constant Real k = 4; end K; package H extends K(k=5); end H; model X Real z = H.k + K.k; end X;

// lenient: computed constants of two packages of one name; K\.q is a computed constant of 2 packages of the name K
package C package K constant Real p = 1; constant Real q = -p; end K; end C; package D package K constant Real p = 2;
constant Real q = +p; end K; end D; model X Real z = C.K.q + D.K.q; end X;

// lenient: a second redeclaration; 'plain' is redeclared, but is not replaceable
model Y extends N(redeclare A plain); end Y; model X Y y(redeclare B plain); end X;

// lenient: a replaceable base; P\.N\.M is replaceable and cannot be a base class
model X extends N.M; end X;

// lenient: a type outside its constraint; which lacks r of P\.Law
model Y replaceable Other a constrainedby Law; end Y; model X Y y; end X;

// lenient: a parameter without a value; parameter y\.p has no value
model Y parameter Real p(start=2); Real z = p; end Y; model X Y y; end X;

// 4: classes, prefixes, types

// illegal: a component with the name of a type; name Integer of a predefined type
model X Real Integer = 3; end X;

// illegal: inner in a record; a of the record Q is inner or outer
record Q inner Real a = 1; end Q; model X Q q; end X;

// illegal: an input that is a model; a is input and of the model P\.A
model Y input A a; end Y; model X Y y; end X;

// illegal: a literal that is an attribute; has a literal start
type E1 = enumeration(low, start); model X parameter E1 e = E1.low; end X;

// illegal: a literal twice; has low twice
type E1 = enumeration(low, low); model X parameter E1 e = E1.low; end X;

// illegal: another enumeration; f is of the enumeration P\.F1, but its value
type E1 = enumeration(low, high); type F1 = enumeration(high, low); model X parameter F1 f = E1.low; end X;

// illegal: another enumeration in a modifier; 'f' is of the enumeration P\.F1
type E1 = enumeration(low, high); type F1 = enumeration(high, low); model Y parameter F1 f = F1.low; end Y; model X Y
y(f=E1.low); end X;

// illegal: another enumeration compared; a comparison has values of
type E1 = enumeration(low, high); type F1 = enumeration(high, low); model X parameter F1 f = F1.low; Boolean b = f ==
E1.low; end X;

// illegal: another enumeration in an if expression; an if expression has values of
type E1 = enumeration(low, high); type F1 = enumeration(high, low); model X parameter Boolean b = true; parameter F1 f
= if b then F1.low else E1.low; end X;

// illegal: another enumeration in a vector; an array has values of
type E1 = enumeration(low, high); type F1 = enumeration(high, low); model X parameter F1 f[2] = {F1.low, E1.low}; end
X;

// illegal: another enumeration as an argument; argument f is of the enumeration P\.F1
type E1 = enumeration(low, high); type F1 = enumeration(high, low); function g input F1 f; output Real y = Integer(f);
algorithm end g; model X Real z = g(E1.low); end X;

// illegal: a constant without a value; constant g has no value
model X constant Real g; Real z = g; end X;

// illegal: a constant with a start value only; constant g has no value
model X constant Real g(start=3); Real z = g; end X;

// illegal: an Integer from a function of time; z changes at events only
function g input Real u; output Integer y = integer(u); algorithm end g; model X Integer z = g(time); end X;

// illegal: a Boolean without events; z changes at events only
model X Boolean z = noEvent(time > 1); end X;

// illegal: time in a record; the record Q uses time
record Q Real a = time; end Q; model X Q q; end X;

// 4.4.5: conditional components

// illegal: a conditional component in an equation; the conditional component c
model X parameter Boolean on = true; Real c = 4 if on; Real z = c; end X;

// 5: scoping

// illegal: a protected parameter; hidden
model X A a; Real z = a.hidden; end X;

// illegal: a protected class; Y\.K uses K, which is protected in P\.Y
model Y protected model K parameter Real k = 1; end K; end Y; model X Y.K k; end X;

// illegal: an element of a protected base; which is protected
model Y protected extends A; end Y; model X Y a; Real z = a.q; end X;

// illegal: a protected element, redeclared; pra, which is protected
model Y extends N(redeclare E pra); end Y; model X Y n; Real z = n.pra.q; end X;

// illegal: a modified outer variable; 'p' is modified, which is outer in P\.Y
model Y outer parameter Real p; Real z = p; end Y; model X inner parameter Real p = 1; Y y(p=2); end X;

// illegal: a function of an array of components; y\.g is a class in an array of components
model Y function g input Real u; output Real y = u; algorithm end g; end Y; model X Y y[2]; Real z = y.g(1); end X;

// 7: inheritance, modification, redeclaration

// illegal: a model as the base of a block; the block X extends the model A
block X extends A; end X;

// illegal: an array as a base; an array of a class
model A2 = A[2]; model X extends A2; Real z = 1; end X;

// illegal: a local class and an inherited one; the class K is declared, and another in the base class P\.Y
model Y model K parameter Real k = 1; end K; end Y; model X model K parameter Real k = 2; end K; extends Y; K c; end
X;

// illegal: two bases that differ; X inherits q twice
model Y parameter Real q = 4; end Y; model X extends A; extends Y; end X;

// illegal: a base by two ways, modified once; X inherits q twice
model Y extends A; end Y; model X extends Y(q=1); extends A; end X;

// illegal: a final component redeclared; 'm' is redeclared, but is final
model Y final replaceable parameter Real m = 2; end Y; model X Y y(redeclare parameter Real m); end X;

// illegal: a final element redeclared; m is redeclared, but is final in P\.Y
model Y final replaceable parameter Real m = 2; end Y; model X extends Y; redeclare parameter Real m = 3; end X;

// illegal: a protected element made public; pra is redeclared as public, but is protected
model X extends N; redeclare A pra; end X;

// illegal: a type of other dimensions; number of dimensions
type V3 = Real[3]; type V23 = Real[2, 3]; model X replaceable V3 v[2] = {{1, 2, 3}, {4, 5, 6}} constrainedby V23; end
X;

// illegal: a class that is no subtype of its constraint; K is of .*, which lacks r of P\.Law
model Y replaceable model K = Other constrainedby Law; K k; end Y; model X Y y; end X;

// 9: connections

// illegal: arrays of connectors of different sizes; connect has 3 elements of b\.c and 2 of a\.c
connector Flange Real s; flow Real f; end Flange; model Wall Flange c; equation c.s = 0; end Wall; model Two Flange
c[2]; equation c.f = {-1, -2}; end Two; model Three Flange c[3]; equation c.s = {1, 2, 3}; end Three; model X Two a;
Three b; equation connect(b.c, a.c); end X;

// illegal: a connector inside of two components; connect uses y\.w\.c, a connector inside of two components
connector Flange Real s; flow Real f; end Flange; model Wall Flange c; equation c.s = 0; end Wall; model Y Wall w;
Wall v; end Y; model X Y y; equation connect(y.w.c, y.v.c); end X;

// illegal: two sources of a signal; connect joins two sources of a signal, a\.y and u
connector In = input Real; connector Out = output Real; block Source Out y; end Source; model Y In u; Source a;
equation connect(u, a.y); end Y; model X Y y(u=1); end X;

// unsupported: the value of a redeclaration; value of the redeclaration of 'm'
model Y replaceable parameter Real m = 2; end Y; model X Y y(redeclare parameter Real m = 3); end X;

// unsupported: the value of a redeclaration with modifiers; value of the redeclaration of 'm'
model Y replaceable parameter Real m = 2; end Y; model X Y y(redeclare parameter Real m(min=0) = 3); end X;

// unsupported: the value of a redeclaration in a base; value of the redeclaration of 'm'
model Y replaceable Real m = 2; end Y; model X extends Y(redeclare Real m = 3); end X;

// unsupported: a replacement without redeclare; 'm' is replaced without
model Y replaceable parameter Real m = 2; end Y; model X Y y(replaceable parameter Real m = 3); end X;

// unsupported: the modifiers of a class; modifiers of the class 'M'
model X extends N(M(q=1)); end X;

// unsupported: a constraining clause of the class itself; modifiers of its constraining clause, r
model X replaceable A a constrainedby Law(r=7); end X;

// unsupported: a short class that shadows; reads q in the modifiers of the short class S
constant Real q = 7; model S = A(r=q); model X S s; end X;

// unsupported: a global type; reads \.P\.A, the type of a, as the local P
model X package P model A Real z = 1; end A; end P; .P.A a; end X;

// unsupported: a global constant; reads \.P\.g as the local P
constant Real g = 1; model X package P constant Real g = 2; end P; Real z = .P.g; end X;

// unsupported: an import of the name of an inherited element; X imports q and inherits an element q
package Q constant Real q = 9; end Q; model X extends A; import P.Q.q; Real z = q; end X;

// unsupported: an import of all names, of which one is inherited; X imports q and inherits an element q
package Q constant Real q = 9; end Q; model X extends A; import P.Q.*; Real z = q; end X;

// unsupported: an import of the name of an inherited class; X imports K and inherits an element K
package Q model K Real v = 3; end K; end Q; model Y model K Real v = 9; end K; end Y; model X extends Y; import P.Q.K;
K k; end X;

// unsupported: an outer Real; the outer Real variable g .*`inner World world`
model Y outer Real g; Real z = g; end Y; model X inner Real g = time; Y y; end X;

// unsupported: inner and outer; g is inner and outer
model Y inner outer A g; Real z = g.q; end Y; model X inner A g; Y y; end X;

// unsupported: a short class of an array; the class P\.A2 of a is an array
model A2 = A[2]; model X A2 a; end X;

// unsupported: an assertion in a for equation of an if equation; drops an assertion in an if equation
model X Real x[2] = {1, 2}*time; equation if time > 0.5 then
for i in 1:2 loop assert(x[i] < 2, "x"); end for; end if; end X;

// unsupported: model extends; `model extends M` is not supported
model X extends N; redeclare model extends M Real w = 1; end M; end X;

// unsupported: model extends without redeclare; `model extends M` is not supported
model X extends N; model extends M Real w = 1; end M; end X;

// front end: a component that is not replaceable; not replaceable
model X N n(redeclare B n); end X;

// front end: no subtype of the declared type; not a subtype
model X N n(redeclare Other a); end X;

// front end: no subtype of the constraint; not a subtype
model X N n(redeclare Other plain); end X;

// front end: a class that is no subtype; not a subtype
model X N n(redeclare model M = Other); end X;

// front end: a constant redeclared; constant elements cannot be redeclared
model X N n(redeclare constant Real c = 2); end X;

// front end: a final parameter; declared final
model X A a(f=1); end X;

// front end: a final component; declared final
model X N n(fa(q=1)); end X;

// front end: a final element of a base; declared final
model X extends A(f=9); end X;

// front end: a modifier made final; declared final
model Y A a(final q=1); end Y; model X Y y(a(q=2)); end X;

// front end: a base's modifier made final; declared final
model Y extends A(final q=1); end Y; model X Y y(q=2); end X;

// front end: an unknown element; unknown modifier `zz`
model X A a(zz=1); end X;

// front end: an unknown attribute of a variable; unknown modifier `zz`
model X Real x(zz=1) = 2; end X;

// front end: an unknown element redeclared; unknown modifier `zz`
model X N n(redeclare B zz); end X;

// front end: sizes that differ; sizes must match
model X A a[2](q={1, 2, 3}); end X;

// front end: each on a scalar; non-array component
model X A a(each q=1); end X;

// front end: a modifier twice; could not be compiled
model X A a(q=1, q=1); end X;

// front end: a redeclaration twice; could not be compiled
model X N n(redeclare B plain, redeclare A plain); end X;

// front end: a record whole and in part; could not be compiled
model X N n(whole=R(1, 2), whole(a=3)); end X;

// front end: a class without redeclare; requires the `redeclare` keyword
model X N n(M=B); end X;

// front end: a value of another type; type mismatch
model X A a(q=true); end X;

// front end: an element twice; could not be compiled
model X Real a = 1; Real a = 2; end X;

// front end: no inner; requires inner
model Y outer Real g; Real z = g; end Y; model X Y y; end X;

// front end: a modified outer; could not be compiled
model Y outer A g(q=1); end Y; model X inner A g; Y y; end X;

// front end: an inner of another type; type mismatch
model Y outer A g; Real z = g.q; end Y; model X inner B g; Y y; end X;

// front end: a partial component; partial model
model X Law i; end X;

// undefined: a parameter that varies; the value of a.q depends on a variable that changes
model X Real x = time; A a(q=x); end X;

// undefined: a start that varies; the start of z depends on a variable that changes
model X Real x = time; Real z(start=x, fixed=true); equation der(z) = -z; end X;

// undefined: a maximum that varies; the maximum of x depends on a variable that changes
model X Real x(max=time) = 1; end X;

// undefined: an infinite parameter; the value of q is not a finite number
model X parameter Real p = 1e200; parameter Real q = p*p; Real x = q; end X;

// undefined: the start of a root of a negative number; the start of x is not a finite number
model X parameter Real p = -1; Real x(start=sqrt(p), fixed=true); equation der(x) = -x; end X;

// undefined: a minimum without a value; the minimum of x is not a finite number
model X parameter Real p = -1; Real x(min=log(p)) = 1; end X;

// right: modifiers of a component; n.n.q = 1; n.arr[1].q = 2
model X N n(n(q=1), arr(each q=2), a(r=3)); end X;

// right: a vector over an array; a[2].q = 2
model X A a[2](q={1, 2}); end X;

// right: each inside each; n[2].arr[1].q = 1
model X N n[2](each arr(each q=1)); end X;

// right: a protected element of a base; hidden = 1
model X extends A(hidden=1); end X;

// right: a clause in a redeclaration; n.a.r = 7; n.a.q = 5
model X Kept n(redeclare B a); end X;

// right: a clause in a base; a.r = 7
model X extends Kept(redeclare B a); end X;

// right: a clause and a modifier of the redeclaration; n.a.r = 8
model X Kept n(redeclare B a(r=8)); end X;

// right: modifiers on both; n.both.r = 7
model X N n(redeclare B both); end X;

// right: modifiers on both, not redeclared; n.both.r = 7
model X N n; end X;

// right: modifiers without a clause; n.a.r = 7
model X N n(redeclare E a); end X;

// right: a redeclared class; n.m.q = 5
model X N n(redeclare model M = B); end X;

// right: a parameter of the class itself without a value; p = 2
model X parameter Real p(start=2); Real z = p; end X;

// right: constants of two heirs; z = 65
package K constant Real k; end K; package H extends K(k=5); end H; package I = K(k=6); model X parameter Real z = H.k
+ 10*I.k; Real w = z; end X;

// unsupported: two redeclarations in extends clauses; the redeclaration of 'plain' is lost
model Y extends N(redeclare replaceable A plain); end Y; model X extends Y(redeclare B plain); end X;

// unsupported: two redeclarations in extends clauses, apart; the redeclaration of 'plain' is lost
model Y extends N(redeclare replaceable A plain); end Y; model Z extends Y; end Z; model X extends Z(redeclare B plain); end X;

// right: two redeclarations of a class in extends clauses; m.q = 5
model Y extends N(redeclare replaceable model M = A); end Y; model X extends Y(redeclare model M = B); end X;

// right: two redeclarations; y.plain.q = 5
model Y extends N(redeclare replaceable A plain); end Y; model X Y y(redeclare B plain); end X;
