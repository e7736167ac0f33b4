"""Chapter 7 of the Modelica Language Specification, 3.6: inheritance, modification and redeclaration."""

import math

from corpus.case import constant, ramp, rule

RULES = [
    rule(
        "7.1 elements of several bases",
        "model A Real a = time; end A; model B Real b = 2*time; end B; model M extends A; extends B; Real y = a + b;"
        " end M;",
        y=ramp(3),
    ),
    rule(
        "7.1 the same element from two bases is one",
        "model A parameter Real k = 2; end A; model B extends A; end B; model C extends A; end C;\n"
        "model M extends B; extends C; Real y = k*time; end M;",
        y=ramp(2),
    ),
    rule(
        "7.1 names of a base are looked up where the base is",
        "package P constant Real k = 5; model A Real z = k*time; end A; end P; constant Real k = 7;\n"
        "model M extends P.A; Real y = z; end M;",
        y=ramp(5),
    ),
    rule(
        "7.1 a base of an extended type",
        "model M extends B(x(start=2, fixed=true)); Real y = x; end M; model B Real x; equation der(x) = 1; end B;",
        y=lambda t: 2 + t,
    ),
    rule(
        "7.1.2 an extends clause below the elements that it uses",
        "model M parameter Real p = 2; Real y = z + p; extends A(k=p); end M; model A parameter Real k = 1;\n"
        "Real z = k*time; end A;",
        y=lambda t: 2 * t + 2,
    ),
    rule(
        "7.2 the outer modifier is stronger",
        "model A parameter Real k = 1; end A; model B A a(k=2); end B; model C B b(a(k=3)); end C;\n"
        "model M C c(b(a(k=4))); Real y = c.b.a.k*time; end M;",
        y=ramp(4),
    ),
    rule(
        "7.2 a modifier with a dotted name",
        "model A parameter Real k = 1; end A; model B A a; end B; model M B b(a.k=5); Real y = b.a.k; end M;",
        y=constant(5),
    ),
    rule(
        "7.2 a modifier is evaluated where it is written",
        "model A parameter Real k = 1; parameter Real p = 100; end A; model M parameter Real p = 3; A a(k=2*p);\n"
        "Real y = a.k; end M;",
        y=constant(6),
    ),
    rule(
        "7.2 a modifier of a short class is evaluated where it is written",
        "constant Real p = 3; model A constant Real p = 100; parameter Real k = 1; end A; model B = A(k=2*p);\n"
        "model M B b; Real y = b.k; end M;",
        y=constant(6),
    ),
    rule(
        "7.2.3 attributes are modified next to the value",
        "model A Real x(start=1, fixed=true); equation der(x) = 1; end A; model M A a(x(start=4)); Real y = a.x; end M;",
        y=lambda t: 4 + t,
    ),
    rule(
        "7.2.4 a modifier of a part of an inherited component",
        "model A parameter Real k = 1; parameter Real m = 2; end A; model B A a(k=5); end B;\n"
        "model M extends B(a(m=6)); Real y = a.k + 10*a.m; end M;",
        y=constant(65),
    ),
    rule(
        "7.2.5 each gives all elements one value",
        "model A parameter Real k = 1; Real z = k*time; end A; model M A a[3](each k=2); Real y = sum(a.z); end M;",
        y=ramp(6),
    ),
    rule(
        "7.2.5 a vector gives each element its own value",
        "model A parameter Real k = 1; Real z = k*time; end A; model M A a[3](k={1, 2, 4}); Real y = a[3].z + a[1].z;"
        " end M;",
        y=ramp(5),
    ),
    rule(
        "7.2.5 a vector through two levels of arrays",
        "model A parameter Real k[2] = {1, 1}; end A; model M A a[2](k=[1, 2; 3, 4]);\n"
        "Real y = a[1].k[2] + 10*a[2].k[1]; end M;",
        y=constant(32),
    ),
    rule(
        "7.2.6 final fixes a value",
        "model A final parameter Real k = 3; parameter Real m = 1; end A; model M A a(m=2); Real y = a.k*a.m*time; end M;",
        y=ramp(6),
    ),
    rule(
        "7.3 a redeclared component keeps the modifiers of its constraint",
        "partial model L parameter Real k = 1; Real z; end L; model A extends L; equation z = k; end A;\n"
        "model B extends L; equation z = 10*k; end B;\n"
        "model C replaceable A a constrainedby L(k=3); end C; model M C c(redeclare B a); Real y = c.a.z; end M;",
        y=constant(30),
    ),
    rule(
        "7.3 a redeclared component with a modifier of its own",
        "model A parameter Real k = 1; Real z = k; end A; model B extends A; parameter Real m = 2; end B;\n"
        "model C replaceable A a; end C; model M C c(redeclare B a(m=5, k=7)); Real y = c.a.z + 10*c.a.m; end M;",
        y=constant(57),
    ),
    rule(
        "7.3 a redeclared class of several components",
        "model A Real z = 1; end A; model B Real z = 2*time; end B; model C replaceable model K = A; K a; K b[2]; end C;\n"
        "model M C c(redeclare model K = B); Real y = c.a.z + sum(c.b.z); end M;",
        y=ramp(6),
    ),
    rule(
        "7.3 a redeclaration in an extends clause",
        "model A Real z = 1; end A; model B Real z = 2*time; end B; model C replaceable model K = A; K a; end C;\n"
        "model M extends C(redeclare model K = B); Real y = a.z; end M;",
        y=ramp(2),
    ),
    rule(
        "7.3 a redeclaration of a parameter's value",
        "model C replaceable parameter Real r = 2; Real z = r*time; end C; model M C c(redeclare parameter Real r = 3);\n"
        "Real y = c.z; end M;",
        y=ramp(3),
    ),
    rule(
        "7.3 a redeclared package",
        "package P constant Real k = 2; end P; package Q constant Real k = 3; end Q;\n"
        "model C replaceable package K = P; Real z = K.k*time; end C; model M C c(redeclare package K = Q); C d;\n"
        "Real y = c.z + 10*d.z; end M;",
        y=ramp(23),
    ),
    rule(
        "7.3 a redeclared record",
        "record R Real a; end R; record S extends R; Real b; end S; model C replaceable record K = R; K r; end C;\n"
        "model M C c(redeclare record K = S); Real y = c.r.a + c.r.b; equation c.r.a = time; c.r.b = 1; end M;",
        y=lambda t: t + 1,
    ),
    rule(
        "7.3 a redeclared function",
        "model C replaceable function f = Shared.square constrainedby Shared.law; Real z = f(time + 1); end C;\n"
        "function own extends Shared.law; algorithm y := x + 7; end own;\n"
        "model M C c(redeclare function f = own); C d; Real y = c.z; Real w = d.z; end M;",
        y=lambda t: t + 8,
        w=lambda t: (t + 1) ** 2,
    ),
    rule(
        "7.3.1 a class that extends the one it replaces",
        "partial model A replaceable model K Real z = 1; end K; end A; model M extends A;\n"
        "redeclare model extends K Real w = 2; end K; K k; Real y = k.z + k.w; end M;",
        y=constant(3),
    ),
    rule(
        "7.3.2 a constraint that is less than the declaration",
        "partial model L Real z; end L; model A extends L; parameter Real k = 1; equation z = k; end A;\n"
        "model B extends L; equation z = 5; end B; model C replaceable A a constrainedby L; end C;\n"
        "model M C c(redeclare B a); Real y = c.a.z; end M;",
        y=constant(5),
    ),
    rule(
        "7.3.3 redeclared twice through replaceable",
        "model A Real z = 1; end A; model B Real z = 2; end B; model D Real z = 4; end D;\n"
        "model C replaceable A a; end C; model E extends C(redeclare replaceable B a); end E;\n"
        "model M E e(redeclare D a); E f; Real y = e.a.z + 10*f.a.z; end M;",
        y=constant(24),
    ),
    rule(
        "7.2 dotted modifiers of an extends clause",
        "model A Real v(start=20, fixed=true); equation der(v) = 1; end A; model B A p(v(start=10)); end B;\n"
        "model C extends B(p.v(start=5)); end C; model M extends C(p.v(start=3)); Real y = p.v; end M;",
        y=lambda t: 3 + t,
    ),
    rule(
        "7.2.5 each in a matrix of components",
        "model A parameter Real p = 1; parameter Real q = 2; end A; model M parameter Real p = 3; A a[2, 3](each p=2*p);\n"
        "Real y = sum(a.p) + 100*a[2, 3].p + 1000*a[1, 3].q; end M;",
        y=constant(36 + 600 + 2000),
    ),
    rule(
        "7.3 a redeclared function with a modifier of its input",
        "function own input Real x; input Real k = 1; output Real y; algorithm y := x + k; end own;\n"
        "model C replaceable function g = own; Real z(start=1, fixed=true); equation der(z) = g(z); end C;\n"
        "model M C c(redeclare function g = own(k=0)); Real y = c.z; end M;",
        y=math.exp,
    ),
]
