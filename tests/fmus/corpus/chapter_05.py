"""Chapters 5 and 13 of the Modelica Language Specification, 3.6: names, inner and outer, packages and imports."""

from corpus.case import constant, ramp, rule, step

RULES = [
    rule(
        "5.3.1 a name is found in the innermost class that has it",
        "constant Real k = 2; model M constant Real k = 3; model A Real z = k*time; end A; A a; Real y = a.z; end M;",
        y=ramp(3),
    ),
    rule(
        "5.3.1 an iterator hides a variable",
        "model M Real i = 100; Real y = sum(i*time for i in 1:3) + i; end M;",
        y=lambda t: 6 * t + 100,
    ),
    rule(
        "5.3.1 encapsulated classes see only what they import",
        "constant Real k = 2; encapsulated model A import Corpus.Shared; Real z = Shared.c*time; end A;\n"
        "model M A a; Real y = a.z; end M;",
        y=ramp(1.5),
    ),
    rule(
        "5.3.2 composite names through packages",
        "package P package Q constant Real k = 4; model A Real z = k*time; end A; end Q; end P;\n"
        "model M P.Q.A a; Real y = a.z + P.Q.k; end M;",
        y=lambda t: 4 * t + 4,
    ),
    rule(
        "5.3.2 a constant of an inherited package",
        "package P constant Real k = 4; end P; package Q extends P; end Q; model M Real y = Q.k*time; end M;",
        y=ramp(4),
    ),
    rule(
        "5.3.2 a constant of a package that is modified in its heir",
        "package P constant Real k = 4; end P; package Q extends P(k=5); end Q; model M Real y = Q.k*time + P.k; end M;",
        y=lambda t: 5 * t + 4,
    ),
    rule(
        "5.3.2 a constant of a renamed package",
        "package P constant Real k = 4; end P; package Q = P(k=6); model M Real y = Q.k*time; end M;",
        y=ramp(6),
    ),
    rule(
        "5.3.3 a name with a leading dot",
        "package Corpus constant Real c = 9; end Corpus; model M Real y = .Corpus.Shared.c*time; end M;",
        y=ramp(1.5),
    ),
    rule(
        "5.4 inner and outer of a Real",
        "model A outer Real g; Real z = 2*g; end A; model M inner Real g = time; A a; Real y = a.z; end M;",
        y=ramp(2),
    ),
    rule(
        "5.4 inner and outer of a parameter",
        "model A outer parameter Real g; Real z = g*time; end A; model B inner parameter Real g = 1; A a; end B;\n"
        "model M B b(g=7); Real y = b.a.z; end M;",
        y=ramp(7),
    ),
    rule(
        "5.4 inner and outer of an Integer",
        "model A outer Integer n; Real z = n*time; end A; model M inner Integer n = if time < 0.5 then 2 else 3; A a;\n"
        "Real y = a.z; end M;",
        y=lambda t: 2 * t if t < 0.5 else 3 * t,
    ),
    rule(
        "5.4 inner and outer of a Boolean",
        "model A outer Boolean on; Real z = if on then 1 else 0; end A; model M inner Boolean on = time > 0.5; A a;\n"
        "Real y = a.z; end M;",
        y=step(0.5, 0, 1),
    ),
    rule(
        "5.4 inner and outer of a component",
        "model W parameter Real g = 1; end W; model A outer W w; Real z = w.g*time; end A;\n"
        "model M inner W w(g=4); A a; Real y = a.z; end M;",
        y=ramp(4),
    ),
    rule(
        "5.4 the nearest inner",
        "model A outer Real g; Real z = g; end A; model B inner Real g = 2*time; A a; end B;\n"
        "model M inner Real g = time; A a; B b; Real y = a.z + 10*b.a.z; end M;",
        y=ramp(21),
    ),
    rule(
        "5.4 outer two levels below inner",
        "model A outer Real g; Real z = g; end A; model B A a; end B; model M inner Real g = 3*time; B b; Real y = b.a.z;"
        " end M;",
        y=ramp(3),
    ),
    rule(
        "5.4 outer in an array of components",
        "model A outer Real g; parameter Real k = 1; Real z = k*g; end A; model M inner Real g = time; A a[2](k={2, 3});\n"
        "Real y = a[1].z + 10*a[2].z; end M;",
        y=ramp(32),
    ),
    rule(
        "5.4 an outer connector",
        "connector C Real e; flow Real f; end C; model A outer C n; C p; equation connect(p, n); p.e = 2*p.f; end A;\n"
        "model M inner C n; A a; A b; Real y = n.e; equation n.f = 0; a.p.f + b.p.f = time; end M;",
        y=ramp(1),
    ),
    rule(
        "13.2.1.1 a qualified import",
        "model M import Corpus.Shared.double; Real y = double(time); end M;",
        y=ramp(2),
    ),
    rule(
        "13.2.1.1 a renaming import",
        "model M import S = Corpus.Shared; Real y = S.double(time) + S.c; end M;",
        y=lambda t: 2 * t + 1.5,
    ),
    rule(
        "13.2.1.1 an import of all",
        "model M import Corpus.Shared.*; Real y = double(time) + c; end M;",
        y=lambda t: 2 * t + 1.5,
    ),
    rule(
        "13.2.1.1 an import of several",
        "model M import Corpus.Shared.{double, c}; Real y = double(time) + c; end M;",
        y=lambda t: 2 * t + 1.5,
    ),
    rule(
        "13.2.1.1 a local name comes before an import of all",
        "model M import Corpus.Shared.*; constant Real c = 8; Real y = c*time; end M;",
        y=ramp(8),
    ),
    rule(
        "13.2.1.1 an import in an enclosing package",
        "package P import Corpus.Shared.scaled; model A Real z = scaled(time); end A; end P;\n"
        "model M P.A a; Real y = a.z; end M;",
        y=lambda t: 3 * t + 1,
    ),
    rule(
        "13.2.1.1 imports are not inherited",
        "model A import Corpus.Shared.c; Real z = c; end A; model M extends A; constant Real c = 4; Real y = z + 10*c;"
        " end M;",
        y=constant(41.5),
    ),
    rule(
        "13.2 constants that depend on each other",
        "package P constant Real a = 2*b; constant Real b = 3; constant Integer n = size(v, 1); constant Real v[:] =\n"
        "{1, a, b}; end P; model M Real y = P.a + 10*P.n + P.v[2]; end M;",
        y=constant(42),
    ),
    rule(
        "13.2 a table of constants",
        "package P constant Real v[2, 3] = [1, 2, 3; 4, 5, 6]; end P; model M Real y = P.v[2, 1]*time + sum(P.v[:, 3]);"
        " end M;",
        y=lambda t: 4 * t + 9,
    ),
    rule(
        "5.3.1 two functions of one name",
        "package P function f input Real x; output Real y; algorithm y := 2*x; end f; model A Real z = f(time); end A; end P;\n"
        "package Q function f input Real x; output Real y; algorithm y := 3*x; end f; model A Real z = f(time); end A; end Q;\n"
        "model M P.A a; Q.A b; Real y = a.z + 10*b.z; end M;",
        y=ramp(32),
    ),
    rule(
        "5.3.1 two records of one name",
        "package P record R Real a = 2*time; end R; model A R r; end A; end P;\n"
        "package Q record R Real a = 3*time; end R; model A R r; end A; end Q;\n"
        "model M P.A a; Q.A b; Real y = a.r.a + 10*b.r.a; end M;",
        y=ramp(32),
    ),
    rule(
        "5.3.1 two enumerations of one name",
        "package P type E = enumeration(a, b); model A parameter E e = E.b; Real z = if e == E.b then 1 else 0; end A; end P;\n"
        "package Q type E = enumeration(b, a); model A parameter E e = E.b; Real z = Integer(e); end A; end Q;\n"
        "model M P.A a; Q.A b; Real y = a.z + 10*b.z; end M;",
        y=constant(11),
    ),
    rule(
        "5.3.1 two constants of one name",
        "package P constant Real k = 2; model A Real z = k*time; end A; end P;\n"
        "package Q constant Real k = 3; model A Real z = k*time; end A; end Q;\n"
        "model M P.A a; Q.A b; Real y = a.z + 10*b.z; end M;",
        y=ramp(32),
    ),
]
