"""Chapters 11 and 12 of the Modelica Language Specification, 3.6: statements and functions."""

import math

from corpus.case import constant, ramp, rule, step

RULES = [
    rule(
        "11.1 an algorithm section runs in order",
        "model M Real y; algorithm y := time; y := 2*y; y := y + 1; end M;",
        y=lambda t: 2 * t + 1,
    ),
    rule(
        "11.1 an algorithm section with a loop",
        "model M Real y; algorithm y := 0; for i in 1:3 loop y := y + i*time; end for; end M;",
        y=ramp(6),
    ),
    rule(
        "11.1 an algorithm section with if",
        "model M Real y; algorithm if time < 0.5 then y := 1; else y := 2; end if; end M;",
        y=step(0.5, 1, 2),
    ),
    rule(
        "11.1 algorithms and equations together",
        "model M Real a; Real b; Real y; equation a = 2*time; y = b + 1; algorithm b := 3*a; end M;",
        y=lambda t: 6 * t + 1,
    ),
    rule(
        "11.1.2 a discrete variable keeps its value in an algorithm",
        "model M Integer y(start=0, fixed=true); algorithm when time > 0.5 then y := pre(y) + 3; end when; end M;",
        y=step(0.5, 0, 3),
    ),
    rule(
        "11.2.1 an assignment to several variables",
        "model M Real r; Real phi; Real y = r + phi; algorithm (r, phi) := Shared.polar(time); end M;",
        y=lambda t: math.hypot(t, 1) + math.atan2(1, t),
    ),
    rule(
        "11.2.2 for statements, nested",
        "function own input Real x; output Real y; algorithm y := 0; for i in 1:3 loop for j in 1:i loop y := y + i*j*x;\n"
        "end for; end for; end own; model M Real y = own(time); end M;",
        y=ramp(25),
    ),
    rule(
        "11.2.2 for statements over a vector",
        "function own input Real x; output Real y; algorithm y := 0; for w in {1, 4, 2} loop y := 10*y + w*x; end for;\n"
        "end own; model M Real y = own(time); end M;",
        y=ramp(142),
    ),
    rule(
        "11.2.2 a for statement downwards",
        "function own input Real x; output Real y; algorithm y := 0; for i in 3:-1:1 loop y := 10*y + i*x; end for; end own;\n"
        "model M Real y = own(time); end M;",
        y=ramp(321),
    ),
    rule(
        "11.2.2 a for statement that never runs",
        "function own input Real x; output Real y; algorithm y := x; for i in 2:1 loop y := 100; end for; end own;\n"
        "model M Real y = own(time); end M;",
        y=ramp(1),
    ),
    rule(
        "11.2.3 while",
        "function own input Real x; output Real y; protected Integer n; algorithm n := 0; y := 0; while n < 5 loop\n"
        "n := n + 1; y := y + n*x; end while; end own; model M Real y = own(time); end M;",
        y=ramp(15),
    ),
    rule(
        "11.2.3 while with a condition on the argument",
        "function own input Real x; output Real y; algorithm y := x + 1; while y > 0.3 loop y := y - 0.3; end while; end own;\n"
        "model M Real y = own(time); end M;",
        y=lambda t: (lambda r: r if r > 0 else 0.3)((1 + t) - 0.3 * math.floor((1 + t) / 0.3)),
    ),
    rule(
        "11.2.4 break leaves the innermost loop",
        "function own input Real x; output Real y; algorithm y := 0; for i in 1:3 loop for j in 1:5 loop if j > i then break;\n"
        "end if; y := y + x; end for; end for; end own; model M Real y = own(time); end M;",
        y=ramp(6),
    ),
    rule(
        "11.2.5 return leaves the function",
        "function own input Real x; output Real y; algorithm y := 1; for i in 1:5 loop y := y + x; if i == 3 then return;\n"
        "end if; end for; y := 100; end own; model M Real y = own(time); end M;",
        y=lambda t: 1 + 3 * t,
    ),
    rule(
        "11.2.6 if statements",
        "function own input Real x; output Real y; algorithm y := 7; if x > 0.7 then y := 1; elseif x > 0.4 then y := x;\n"
        "elseif x > 0.2 then y := 2*x; end if; end own; model M Real y = own(time); end M;",
        y=lambda t: 1 if t > 0.7 else t if t > 0.4 else 2 * t if t > 0.2 else 7,
    ),
    rule(
        "11.2.6 an if statement that assigns a part of an array",
        "function own input Real x; output Real y[3]; algorithm y := {1, 2, 3}; if x > 0.5 then y[2] := 10*x; end if; end own;\n"
        "model M Real z[3] = own(time); Real y = z[2] + z[3]; end M;",
        y=lambda t: (10 * t if t > 0.5 else 2) + 3,
    ),
    rule(
        "11.2.8 an assertion in an algorithm",
        'model M Real y = time; algorithm assert(time < 2, "time is too large"); end M;',
        y=ramp(1),
    ),
    rule(
        "12.1 a function with a binding of a local variable",
        "function own input Real x; output Real y; protected Real a = 2*x; Real b = a + 1; algorithm y := a*b; end own;\n"
        "model M Real y = own(time); end M;",
        y=lambda t: 2 * t * (2 * t + 1),
    ),
    rule(
        "12.1 a function whose output has a default",
        "function own input Real x; output Real y = 3*x; algorithm end own; model M Real y = own(time); end M;",
        y=ramp(3),
    ),
    rule(
        "12.2 a pure function is evaluated where it is called",
        "function own input Real x[2]; input Real k; output Real y[2]; algorithm y := k*x; y[1] := y[1] + 1; end own;\n"
        "model M Real z[2] = own({time, 2}, 3); Real y = z[1] + 10*z[2]; end M;",
        y=lambda t: 3 * t + 1 + 60,
    ),
    rule(
        "12.4 a function in an equation of its inverse",
        "model M Real x(start=1); Real y = x; equation Shared.square(x) = 4 + time; end M;",
        y=lambda t: math.sqrt(4 + t),
    ),
    rule(
        "12.4.1 defaults that use other inputs",
        "function own input Real x; input Real k = 2*x; output Real y; algorithm y := x + k; end own;\n"
        "model M Real y = own(time) + 100*own(time, 1); end M;",
        y=lambda t: 3 * t + 100 * (t + 1),
    ),
    rule(
        "12.4.2 functions as arguments",
        "function own input Shared.law f; input Real x; output Real y; algorithm y := f(x) + 1; end own;\n"
        "model M Real y = own(function Shared.square(), time); end M;",
        y=lambda t: t * t + 1,
    ),
    rule(
        "12.4.3 three results, two of them used",
        "function own input Real x; output Real a; output Real b; output Real c; algorithm a := x; b := 2*x; c := 3*x; end own;\n"
        "model M Real a; Real c; Real y = a + 10*c; equation (a, , c) = own(time); end M;",
        y=ramp(31),
    ),
    rule(
        "12.4.4 a function of a matrix whose sizes depend on the argument",
        "function own input Real a[:, :]; output Real y[size(a, 2), size(a, 1)]; algorithm for i in 1:size(a, 1) loop\n"
        "for j in 1:size(a, 2) loop y[j, i] := a[i, j]; end for; end for; end own;\n"
        "model M Real z[3, 2] = own([1, 2, 3; 4, 5, 6]*time); Real y = z[3, 1] + 10*z[1, 2]; end M;",
        y=ramp(43),
    ),
    rule(
        "12.4.6 a scalar function of a vector",
        "function own input Real x; input Real k; output Real y; algorithm y := k*x; end own;\n"
        "model M Real z[3] = own({1, 2, 3}, time); Real y = z[3] + 10*z[1]; end M;",
        y=ramp(13),
    ),
    rule(
        "12.5 built-in functions in functions",
        "function own input Real x; output Real y; algorithm y := sqrt(abs(x - 0.5)) + max({x, 0.3}) + sum({x, 1}); end own;\n"
        "model M Real y = own(time); end M;",
        y=lambda t: math.sqrt(abs(t - 0.5)) + max(t, 0.3) + t + 1,
    ),
    rule(
        "12.6 a record as argument and result",
        "function own input Shared.Pair p; output Shared.Pair q; algorithm q.a := p.b; q.b := 2*p.a; end own;\n"
        "model M Shared.Pair p; Shared.Pair q = own(p); Real y = q.a + 10*q.b; equation p.a = time; p.b = 5; end M;",
        y=lambda t: 5 + 20 * t,
    ),
    rule(
        "12.6 a record constructor with defaults",
        "record R Real a; Real b = 2; Real c = 3; end R; model M R r = R(time, c=7); Real y = r.a + 10*r.b + 100*r.c; end M;",
        y=lambda t: t + 720,
    ),
    rule(
        "12.6 a constructor of a derived record",
        "record R Real a; Real b = 2; end R; record S = R(b=5); model M S s = S(a=time); Real y = s.a + 10*s.b; end M;",
        y=lambda t: t + 50,
    ),
    rule(
        "12.7.1 an annotation of the derivative",
        "function own input Real x; output Real y; algorithm y := x^3; annotation(derivative=ownder); end own;\n"
        "function ownder input Real x; input Real dx; output Real dy; algorithm dy := 3*x^2*dx; end ownder;\n"
        "model M Real z = own(time); Real y = der(z); end M;",
        y=lambda t: 3 * t * t,
    ),
    rule(
        "12 recursion",
        "function own input Integer n; output Integer y; algorithm y := if n <= 1 then n else own(n - 1) + own(n - 2); end own;\n"
        "model M Real y = own(10); end M;",
        y=constant(55),
    ),
    rule(
        "12 an Integer function",
        "function own input Integer n; output Integer y; algorithm y := div(n, 2) + mod(n, 3); end own;\n"
        "model M Integer k = integer(10*time); Real y = own(k); end M;",
        y=lambda t: math.floor(10 * t) // 2 + math.floor(10 * t) % 3,
    ),
    rule(
        "12 a Boolean function",
        "function own input Real x; input Boolean b; output Boolean y; algorithm y := b and x > 0.5; end own;\n"
        "model M Real y = if own(time, true) then 1 else 0; end M;",
        y=step(0.5, 0, 1),
    ),
    rule(
        "12 a function of an enumeration",
        "function own input Shared.Gear g; output Real y; algorithm y := if g == Shared.Gear.low then 1 elseif\n"
        "g == Shared.Gear.middle then 2.5 else 4; end own;\n"
        "model M Shared.Gear g = if time < 0.5 then Shared.Gear.middle else Shared.Gear.high; Real y = own(g); end M;",
        y=step(0.5, 2.5, 4),
    ),
    rule(
        "12 a table that a function interpolates",
        "function own input Real x; input Real xs[:]; input Real ys[size(xs, 1)]; output Real y; algorithm y := ys[1];\n"
        "for i in 1:size(xs, 1) - 1 loop y := y + (ys[i + 1] - ys[i])*min(max((x - xs[i])/(xs[i + 1] - xs[i]), 0), 1);\n"
        "end for; end own; model M Real y = own(time, {0.2, 0.5, 0.8}, {1, 3, 2}); end M;",
        y=lambda t: 1 + 2 * min(max((t - 0.2) / 0.3, 0), 1) - min(max((t - 0.5) / 0.3, 0), 1),
    ),
    rule(
        "14 operator records",
        "operator record V Real a; encapsulated operator function '+' input V p; input V q; output V r;\n"
        "algorithm r := V(p.a + q.a + 1); end '+'; end V; model M V p = V(time); V q = p + p; Real y = q.a; end M;",
        y=lambda t: 2 * t + 1,
    ),
    rule(
        "16 a clock",
        "model M Real x = 2*time; Real z = sample(x, Clock(0.1)); Real y = hold(z); end M;",
        y=lambda t: 0.2 * math.floor(10 * t + 1e-9),
    ),
    rule(
        "17 a state machine",
        "model M block A outer output Integer n(start=0); equation n = previous(n) + 1; end A; inner Integer n(start=0); A a;\n"
        "Real y = n; equation initialState(a); end M;",
        y=constant(1),
    ),
    rule(
        "18 annotations of evaluation and inlining",
        "function own input Real x; output Real y; algorithm y := 2*x; annotation(Inline=true); end own;\n"
        "model M parameter Real k = 3 annotation(Evaluate=true); Real y = k*own(time); end M;",
        y=ramp(6),
    ),
    rule(
        "2 comments and quoted names",
        "model M /* a comment // in a comment */ Real 'a b' = time; // the rest; of a line\n"
        'Real y = 2*\'a b\' "text with \\"quotes\\""; end M;',
        y=ramp(2),
    ),
    rule(
        "6 a record of another name with the same fields",
        "record R Real a; Real b; end R; model M R r = R(time, 2); Real y = Shared.norm(Shared.Pair(r.a, r.b)); end M;",
        y=lambda t: math.hypot(t, 2),
    ),
]
