"""Chapter 4 of the Modelica Language Specification, 3.6: classes, predefined types and declarations."""

from corpus.case import constant, ramp, rule, step

RULES = [
    rule(
        "4.4 the order of declarations does not matter",
        "model M Real y = a + b; parameter Real b = 2*a; parameter Real a = 3; end M;",
        y=constant(9),
    ),
    rule(
        "4.4.2 a declaration of several variables with one type",
        "model M Real a(start=1, fixed=true), b[2](each start=2, each fixed=true), y; equation der(a) = 1;\n"
        "der(b) = {1, 2}; y = a + b[1] + b[2]; end M;",
        y=lambda t: 5 + 4 * t,
    ),
    rule(
        "4.4.2 dimensions at the type and at the name",
        "model M Real[3] a[2]; Real y = a[2, 3] + 10*size(a, 1) + 100*size(a, 2); equation\n"
        "a = [1, 2, 3; 4, 5, 6]*time; end M;",
        y=lambda t: 6 * t + 320,
    ),
    rule(
        "4.4.4 parameters that depend on others",
        "model M parameter Real a = 2; parameter Real b = a^2; final parameter Real c = a + b; Real y = c*time; end M;",
        y=ramp(6),
    ),
    rule(
        "4.4.4 a constant with a structural use",
        "model M constant Integer n = 3; Real x[n] = {i*time for i in 1:n}; Real y = sum(x); end M;",
        y=ramp(6),
    ),
    rule(
        "4.4.4 a parameter as the size of an array",
        "model A parameter Integer n = 2; Real x[n](each start=1, each fixed=true); Real y = sum(x); equation\n"
        "for i in 1:n loop der(x[i]) = i; end for; end A; model M A a(n=3); Real y = a.y; end M;",
        y=lambda t: 3 + 6 * t,
    ),
    rule(
        "4.4.4 a size from the binding",
        "model M parameter Real v[:] = {1, 2, 4}; Real y = size(v, 1) + v[3]*time; end M;",
        y=lambda t: 3 + 4 * t,
    ),
    rule(
        "4.4.4 a size from a modifier",
        "model A parameter Real v[:]; Real y = size(v, 1) + sum(v); end A; model M A a(v={1, 2, 4, 8}); Real y = a.y;"
        " end M;",
        y=constant(19),
    ),
    rule(
        "4.4.4 a discrete Real keeps its value",
        "model M discrete Real y(start=3, fixed=true); equation when time > 0.5 then y = time; end when; end M;",
        y=step(0.5, 3, 0.5),
    ),
    rule(
        "4.4.4 Integer and Boolean variables with equations",
        "model M Integer k = if b then 1 else -1; Boolean b = time < 0.3; Real y = 2*k; end M;",
        y=step(0.3, 2, -2),
    ),
    rule(
        "4.4.5 a conditional component that is absent",
        "model A Real z = 1; end A; model M parameter Boolean has = false; A a if has; A b if not has; Real y = time;"
        " end M;",
        y=ramp(1),
    ),
    rule(
        "4.4.5 connections to an absent component vanish",
        "connector C Real e; flow Real f; end C; model R C p; equation p.e = 2*p.f; end R;\n"
        "model S C p; equation p.f = -3; end S;\n"
        "model M S s; R r1; R r2 if false; Real y = r1.p.e; equation connect(s.p, r1.p); connect(s.p, r2.p); end M;",
        y=constant(6),
    ),
    rule(
        "4.4.5 connections to a present component",
        "connector C Real e; flow Real f; end C; model R C p; equation p.e = 2*p.f; end R;\n"
        "model S C p; equation p.f = -3; end S;\n"
        "model M S s; R r1; R r2 if true; Real y = r1.p.e; equation connect(s.p, r1.p); connect(s.p, r2.p); end M;",
        y=constant(3),
    ),
    rule(
        "4.5 a short class with modifiers",
        "model A parameter Real k = 1; Real y = k*time; end A; model B = A(k=4); model M B b; Real y = b.y; end M;",
        y=ramp(4),
    ),
    rule(
        "4.5.1 a type with an attribute and its derived types",
        'type Length = Real(unit="m", min=0); type Height = Length(max=10); model M Height h(start=2, fixed=true);\n'
        "Real y = h; equation der(h) = 1; end M;",
        y=lambda t: 2 + t,
    ),
    rule(
        "4.5.1 a type that is an array",
        "type Point = Real[3]; model M Point p = {time, 2*time, 1}; Real y = sum(p) + size(p, 1); end M;",
        y=lambda t: 3 * t + 4,
    ),
    rule(
        "4.5.1 an array of an array type",
        "type Point = Real[3]; model M Point p[2]; Real y = p[2, 3] + 10*size(p, 1) + 100*size(p, 2); equation\n"
        "p = [1, 2, 3; 4, 5, 6]*time; end M;",
        y=lambda t: 6 * t + 320,
    ),
    rule(
        "4.5.3 a local class",
        "model M model A Real z = 2*time; end A; A a; Real y = a.z; end M;",
        y=ramp(2),
    ),
    rule(
        "4.6 a block with inputs and outputs",
        "block B input Real u; output Real v; equation v = 3*u; end B; model M B b(u=time); Real y = b.v; end M;",
        y=ramp(3),
    ),
    rule(
        "4.6 a record with a binding for each field",
        "record R Real a = 1; Real b = a + 1; end R; model M R r(a=time); Real y = r.b; end M;",
        y=lambda t: t + 1,
    ),
    rule(
        "4.6 records in records",
        "model M Shared.Nested n = Shared.Nested(Shared.Pair(time, 2), 3); Real y = n.p.a + 10*n.p.b + 100*n.c; end M;",
        y=lambda t: t + 320,
    ),
    rule(
        "4.6 arrays of records",
        "model M Shared.Pair p[2]; Real y = p[1].a + 10*p[2].b + sum(p.a); equation for i in 1:2 loop\n"
        "p[i].a = i*time; p[i].b = i + time; end for; end M;",
        y=lambda t: t + 10 * (2 + t) + 3 * t,
    ),
    rule(
        "4.6 equations between records",
        "model M Shared.Pair p; Shared.Pair q; Real y = q.a + q.b; equation p.a = time; p.b = 2*time; q = p; end M;",
        y=ramp(3),
    ),
    rule(
        "4.6 a record of parameters",
        "record R parameter Real a = 1; parameter Real b = 2; end R; model M parameter R r(b=5); R s = r;\n"
        "Real y = r.a + s.b; end M;",
        y=constant(6),
    ),
    rule(
        "4.6 a record that extends another",
        "record A Real a; end A; record B extends A; Real b; end B; model M B r; Real y = r.a + r.b; equation\n"
        "r.a = time; r.b = 1; end M;",
        y=lambda t: t + 1,
    ),
    rule(
        "4.8 balanced: a partial model completed by its heir",
        "partial model A Real x; Real y; equation y = 2*x; end A; model M extends A; equation x = time; end M;",
        y=ramp(2),
    ),
    rule(
        "4.9.1 a start value that is only a guess",
        "model M Real y(start=3); equation y^2 = 16; end M;",
        y=constant(4),
    ),
    rule(
        "4.9.1 a guess selects the other root",
        "model M Real y(start=-3); equation y^2 = 16; end M;",
        y=constant(-4),
    ),
    rule(
        "4.9.5 an enumeration as a parameter",
        'type E = enumeration(a "first", b, c); model M parameter E e = E.c; Real y = if e == E.c then 1\n'
        "elseif e > E.a then 2 else 3; end M;",
        y=constant(1),
    ),
    rule(
        "4.9.5 an enumeration that changes",
        "model M Shared.Gear g = if time < 0.5 then Shared.Gear.low else Shared.Gear.high;\n"
        "Real y = if g == Shared.Gear.high then 1 else 0; end M;",
        y=step(0.5, 0, 1),
    ),
    rule(
        "4.9.5 an enumeration as an index",
        "model M Real v[Shared.Gear] = {1, 2*time, 3}; Real y = v[Shared.Gear.middle]; end M;",
        y=ramp(2),
    ),
    rule(
        "4.9.5 a loop over an enumeration",
        "model M Real v[Shared.Gear]; Real y = v[Shared.Gear.high]; equation for g in Shared.Gear loop\n"
        "v[g] = Integer(g)*time; end for; end M;",
        y=ramp(3),
    ),
    rule(
        "4.9.5 a Boolean as an index",
        "model M Real v[Boolean] = {1, 2*time}; Real y = v[true] + 10*v[false]; end M;",
        y=lambda t: 2 * t + 10,
    ),
    rule(
        "4.9.6 stateSelect decides which state is kept",
        "model M Real a(start=1, fixed=true, stateSelect=StateSelect.prefer); Real b; Real y = b; equation der(a) = 1;\n"
        "b = 2*a; end M;",
        y=lambda t: 2 + 2 * t,
    ),
    rule(
        "4.9 String parameters that nothing uses",
        'model M parameter String file = "none"; Real y = time; end M;',
        y=ramp(1),
    ),
]
