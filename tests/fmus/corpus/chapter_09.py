"""Chapters 9 and 15 of the Modelica Language Specification, 3.6: connectors and connections."""

from corpus.case import constant, ramp, rule

PHYSICAL = (
    "connector C Real e; flow Real f; end C;\n"
    "model R parameter Real k = 1; C a; C b; equation a.f + b.f = 0; a.e - b.e = k*a.f; end R;\n"
    "model S C a; equation a.e = 6*time; end S; model G C a; equation a.e = 0; end G;\n"
)

RULES = [
    rule(
        "9.2 flows sum to zero and potentials are equal",
        f"{PHYSICAL}model M S s; G g; R r1; R r2(k=2); Real y = -s.a.f; equation connect(s.a, r1.a); connect(s.a, r2.a);\n"
        "connect(r1.b, g.a); connect(r2.b, g.a); end M;",
        y=ramp(9),
    ),
    rule(
        "9.2 a chain of connections is one set",
        f"{PHYSICAL}model M S s; G g; R r1; R r2; R r3; Real y = r1.a.f + r2.a.f + r3.a.f; equation\n"
        "connect(r1.a, r2.a); connect(r2.a, r3.a); connect(r3.a, s.a); connect(r1.b, g.a); connect(g.a, r2.b);\n"
        "connect(r2.b, r3.b); end M;",
        y=ramp(18),
    ),
    rule(
        "9.2 a connection that is made twice",
        f"{PHYSICAL}model M S s; G g; R r; Real y = r.a.f; equation connect(s.a, r.a); connect(r.a, s.a);\n"
        "connect(r.b, g.a); end M;",
        y=ramp(6),
    ),
    rule(
        "9.2 the flow of an unconnected connector is zero",
        f"{PHYSICAL}model M S s; R r; R open; Real y = r.b.e + open.a.f; equation connect(s.a, r.a); connect(r.b, open.a);"
        " end M;",
        y=ramp(6),
    ),
    rule(
        "9.2 flows of an outside connector have the other sign",
        f"{PHYSICAL}model P C a; C b; R r1; R r2; equation connect(a, r1.a); connect(r1.b, r2.a); connect(r2.b, b); end P;\n"
        "model M S s; G g; P p; Real y = p.a.f; equation connect(s.a, p.a); connect(p.b, g.a); end M;",
        y=ramp(3),
    ),
    rule(
        "9.2 outside connectors through two levels",
        f"{PHYSICAL}model P C a; C b; R r; equation connect(a, r.a); connect(r.b, b); end P;\n"
        "model Q C a; C b; P p; equation connect(a, p.a); connect(p.b, b); end Q;\n"
        "model M S s; G g; Q q; Real y = q.a.f; equation connect(s.a, q.a); connect(q.b, g.a); end M;",
        y=ramp(6),
    ),
    rule(
        "9.2 arrays of connectors",
        f"{PHYSICAL}model P C c[2]; equation c[1].e = 2*c[1].f; c[2].e = 3*c[2].f; end P;\n"
        "model Q C c[2]; equation c.e = {6*time, 6}; end Q;\n"
        "model M P p; Q q; Real y = p.c[1].f + 10*p.c[2].f; equation connect(p.c, q.c); end M;",
        y=lambda t: 3 * t + 20,
    ),
    rule(
        "9.2 an element of an array of connectors",
        f"{PHYSICAL}model P C c[2]; equation c[1].e = 2*c[1].f; c[2].e = 3*c[2].f; end P;\n"
        "model M P p; S s; G g; Real y = p.c[2].f; equation connect(p.c[2], s.a); connect(p.c[1], g.a); end M;",
        y=ramp(2),
    ),
    rule(
        "9.1 a connector in a connector",
        f"{PHYSICAL}connector D C p; C q; end D; model A D d; equation d.p.e = 2*d.p.f; d.q.e = 3*d.q.f; end A;\n"
        "model B D d; equation d.p.e = 6*time; d.q.e = 12; end B; model M A a; B b; Real y = a.d.p.f + a.d.q.f; equation\n"
        "connect(a.d, b.d); end M;",
        y=lambda t: 3 * t + 4,
    ),
    rule(
        "9.1 a connector with arrays",
        "connector C Real e[3]; flow Real f[3]; end C; model A C c; equation c.e = 2*c.f; end A;\n"
        "model B C c; equation c.e = {2, 4*time, 6}; end B; model M A a; B b; Real y = a.c.f[2] + a.c.f[3]; equation\n"
        "connect(a.c, b.c); end M;",
        y=lambda t: 2 * t + 3,
    ),
    rule(
        "9.1 causal connectors",
        "connector I = input Real; connector O = output Real; block G parameter Real k = 2; I u; O v; equation v = k*u;\n"
        "end G; block S O v = time; end S; model M S s; G g; G h(k=5); Real y = h.v; equation connect(s.v, g.u);\n"
        "connect(g.v, h.u); end M;",
        y=ramp(10),
    ),
    rule(
        "9.1 one output to several inputs",
        "connector I = input Real; connector O = output Real; block G I u; Real z = 3*u; end G; block S O v = time; end S;\n"
        "model M S s; G g; G h; Real y = g.z + h.z; equation connect(s.v, g.u); connect(s.v, h.u); end M;",
        y=ramp(6),
    ),
    rule(
        "9.1 Boolean and Integer connectors",
        "connector I = input Boolean; connector O = output Boolean; connector N = input Integer;\n"
        "connector P = output Integer; block S O b = time > 0.5; P n = 4; end S;\n"
        "block G I b; N n; Real z = if b then n else 0; end G; model M S s; G g; Real y = g.z; equation\n"
        "connect(s.b, g.b); connect(s.n, g.n); end M;",
        y=lambda t: 4 if t > 0.5 else 0,
    ),
    rule(
        "9.1 vectors of signals",
        "connector I = input Real; connector O = output Real; block S O v[3] = {1, time, 3}; end S;\n"
        "block G I u[3]; Real z = u[1] + 10*u[2] + 100*u[3]; end G; model M S s; G g; Real y = g.z; equation\n"
        "connect(s.v, g.u); end M;",
        y=lambda t: 1 + 10 * t + 300,
    ),
    rule(
        "9.1.3 expandable connectors",
        "expandable connector B end B; connector I = input Real; connector O = output Real; block S O v = time; end S;\n"
        "block G I u; Real z = 2*u; end G; model M B bus; S s; G g; Real y = g.z; equation connect(s.v, bus.v);\n"
        "connect(bus.v, g.u); end M;",
        y=ramp(2),
    ),
    rule(
        "9.3 a parameter in a connector",
        "connector C parameter Integer n = 2; Real e; flow Real f; end C; model A C c(n=3); equation c.e = c.n*c.f; end A;\n"
        "model B C c(n=3); equation c.f = -time; end B; model M A a; B b; Real y = a.c.e; equation connect(a.c, b.c); end M;",
        y=ramp(3),
    ),
    rule(
        "9.4 overconstrained connections",
        "type O extends Real; function equalityConstraint input O a; input O b; output Real r[0]; algorithm end\n"
        "equalityConstraint; end O; connector C O o; flow Real f; end C; model M C a; Real y = 1; equation\n"
        "Connections.root(a.o); a.o = 1; end M;",
        y=constant(1),
    ),
    rule(
        "15.1 stream connectors",
        "connector C Real p; flow Real m; stream Real h; end C; model A C c; equation c.m = -1; c.h = 5; end A;\n"
        "model B C c; Real z = inStream(c.h); equation c.p = 1; c.h = 3; end B; model M A a; B b; Real y = b.z; equation\n"
        "connect(a.c, b.c); end M;",
        y=constant(5),
    ),
]
