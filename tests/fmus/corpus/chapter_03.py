"""Chapter 3 of the Modelica Language Specification, 3.6: operators and expressions, mostly those that make events."""

import math

from corpus.case import constant, ramp, rule, step

RULES = [
    rule(
        "3.3 the condition of an if expression decides which branch is evaluated",
        "model M Real x = time - 0.5; Real y = noEvent(if x > 0 then sqrt(x) else 0); end M;",
        y=lambda t: math.sqrt(max(t - 0.5, 0)),
    ),
    rule(
        "3.5 relations of Integers",
        "model M Integer n = integer(10*time); Real y = if n == 3 then 1 elseif n <> 4 then 2 else 3; end M;",
        y=lambda t: 1 if 3 <= 10 * t < 4 else 3 if 4 <= 10 * t < 5 else 2,
    ),
    rule(
        "3.5 relations of Strings",
        'model M parameter String s = "b"; Real y = if s == "b" then 1 else 2; end M;',
        y=constant(1),
    ),
    rule(
        "3.6.1 not, and, or of Booleans over time",
        "model M Boolean a = time > 0.25; Boolean b = time > 0.5; Boolean c = a and not b or time > 0.75;\n"
        "Real y = if c then 1 else 0; end M;",
        y=lambda t: 1 if 0.25 < t <= 0.5 or t > 0.75 else 0,
    ),
    rule(
        "3.6.5 a Boolean if expression",
        "model M Boolean a = if time > 0.5 then time > 0.75 else time > 0.25; Real y = if a then 1 else 0; end M;",
        y=lambda t: 1 if t > 0.75 or 0.25 < t <= 0.5 else 0,
    ),
    rule(
        "3.7.1 the number of an enumeration literal",
        "model M parameter Shared.Gear g = Shared.Gear.middle; Real y = Integer(g); end M;",
        y=constant(2),
    ),
    rule(
        "3.7.2 floor of time jumps at whole multiples",
        "model M Real y = floor(4*time); Integer n(start=0, fixed=true); equation\n"
        "when change(y) then n = pre(n) + 1; end when; end M;",
        y=lambda t: math.floor(4 * t),
        n=lambda t: math.floor(4 * t),
    ),
    rule(
        "3.7.2 mod of time as a saw tooth",
        "model M Real y = mod(time, 0.3); end M;",
        y=lambda t: t - 0.3 * math.floor(t / 0.3),
    ),
    rule(
        "3.7.2 a pulse of mod",
        "model M Boolean on = mod(time, 0.3) < 0.1; Real y = if on then 1 else 0; Real x(start=0, fixed=true);\n"
        "equation der(x) = y; end M;",
        y=lambda t: 1 if t - 0.3 * math.floor(t / 0.3) < 0.1 else 0,
        x=lambda t: 0.1 * math.floor(t / 0.3) + min(0.1, t - 0.3 * math.floor(t / 0.3)),
    ),
    rule(
        "3.7.2 div and rem of Integers",
        "model M Integer n = integer(10*time); Integer d = div(n, 3); Integer r = rem(n, 3); Integer m = mod(n - 5, 3);\n"
        "Real y = 100*d + 10*r + m; end M;",
        y=lambda t: 100 * (math.floor(10 * t) // 3) + 10 * (math.floor(10 * t) % 3) + (math.floor(10 * t) - 5) % 3,
    ),
    rule(
        "3.7.2 integer of a state counts revolutions",
        "model M Real s(start=0, fixed=true); Integer i = integer(s); Real y = i; equation der(s) = 3.3; end M;",
        y=lambda t: math.floor(3.3 * t),
    ),
    rule(
        "3.7.2 floor of a falling state",
        "model M Real s(start=1.6, fixed=true); Real y = floor(s); equation der(s) = -3.3; end M;",
        y=lambda t: math.floor(1.6 - 3.3 * t),
    ),
    rule(
        "3.7.3 sign of a state",
        "model M Real s(start=-0.5, fixed=true); Real y = sign(s); equation der(s) = 1; end M;",
        y=lambda t: 1 if t > 0.5 else -1,
    ),
    rule(
        "3.7.4 der of an array",
        "model M Real x[2](start={1, 2}, each fixed=true); Real y = x[1] + 10*x[2]; equation der(x) = {1, -2}; end M;",
        y=lambda t: 1 + t + 10 * (2 - 2 * t),
    ),
    rule(
        "3.7.4 der of a product of states",
        "model M Real a(start=1, fixed=true); Real b(start=2, fixed=true); Real y = der(a*b); equation der(a) = 1;\n"
        "der(b) = -1; end M;",
        y=lambda t: (2 - t) - (1 + t),
    ),
    rule(
        "3.7.4 der of a parameter is zero",
        "model M parameter Real p = 3; Real y = der(p) + 1; end M;",
        y=constant(1),
    ),
    rule(
        "3.7.4 second derivative",
        "model M Real x = sin(2*time); Real v = der(x); Real y = der(v); end M;",
        y=lambda t: -4 * math.sin(2 * t),
    ),
    rule(
        "3.7.4 delay",
        "model M Real y = delay(time, 0.2); end M;",
        y=lambda t: max(t - 0.2, 0),
    ),
    rule(
        "3.7.4 cardinality",
        "connector C Real e; flow Real f; end C; model M C a; C b; Real y = cardinality(a); equation connect(a, b);\n"
        "a.e = 1; end M;",
        y=constant(1),
    ),
    rule(
        "3.7.4 semiLinear with different slopes",
        "model M Real x = 2*time - 1; Real y = semiLinear(x, 1 + time, 5); end M;",
        y=lambda t: (2 * t - 1) * (1 + t if t >= 0.5 else 5),
    ),
    rule(
        "3.7.4 homotopy has its actual value",
        "model M Real y(start=1); equation homotopy(actual=y^3, simplified=y) = 8; end M;",
        y=constant(2),
    ),
    rule(
        "3.7.5 initial is true during initialization only",
        "model M Real y(start=0, fixed=true); Integer n(start=5); equation der(y) = n;\n"
        "when initial() then n = 2; end when; end M;",
        y=lambda t: 2 * t,
    ),
    rule(
        "3.7.5 initial in an if expression",
        "model M Real y = if initial() then 1 else 0; Real x(start=1, fixed=true); equation der(x) = y; end M;",
        x=constant(1),
    ),
    rule(
        "3.7.5 terminal is false while the simulation runs",
        "model M Real y = if terminal() then 1 else 0; end M;",
        y=constant(0),
    ),
    rule(
        "3.7.5 noEvent with a relation that holds from the start",
        "model M Real y = noEvent(if time >= 0 then 2 else 1); end M;",
        y=constant(2),
    ),
    rule(
        "3.7.5 sample counts from its start",
        "model M Integer y(start=0, fixed=true); equation when sample(0.25, 0.2) then y = pre(y) + 1; end when; end M;",
        y=lambda t: 0 if t < 0.25 else 1 + math.floor((t - 0.25) / 0.2 + 1e-9),
    ),
    rule(
        "3.7.5 sample at the start of the simulation",
        "model M Integer y(start=0, fixed=true); equation when sample(0, 0.3) then y = pre(y) + 1; end when; end M;",
        y=lambda t: 1 + math.floor(t / 0.3 + 1e-9),
    ),
    rule(
        "3.7.5 two clocks that coincide",
        "model M Integer a(start=0, fixed=true); Integer b(start=0, fixed=true); Real y = 10*a + b; equation\n"
        "when sample(0.1, 0.1) then a = pre(a) + 1; end when; when sample(0.2, 0.2) then b = pre(b) + pre(a); end when;"
        " end M;",
        y=lambda t: 10 * math.floor(10 * t + 1e-9) + sum(2 * k - 1 for k in range(1, math.floor(5 * t + 1e-9) + 1)),
    ),
    rule(
        "3.7.5 sample as a Boolean",
        "model M Boolean s = sample(0.15, 0.3); Integer y(start=0, fixed=true); equation\n"
        "when s then y = pre(y) + 1; end when; end M;",
        y=lambda t: 0 if t < 0.15 else 1 + math.floor((t - 0.15) / 0.3 + 1e-9),
    ),
    rule(
        "3.7.5 pre is the value before the event",
        "model M discrete Real a(start=1, fixed=true); discrete Real y(start=7, fixed=true); equation\n"
        "when sample(0.2, 0.2) then a = 2*pre(a); y = pre(a); end when; end M;",
        y=lambda t: 7 if t < 0.2 else 2 ** (math.floor(5 * t + 1e-9) - 1),
        a=lambda t: 2 ** math.floor(5 * t + 1e-9),
    ),
    rule(
        "3.7.5 edge of a Boolean",
        "model M Boolean b = sin(20*time) > 0.5; Integer y(start=0, fixed=true); equation\n"
        "when edge(b) then y = pre(y) + 1; end when; end M;",
        y=lambda t: 0 if t < math.asin(0.5) / 20 else 1 + math.floor((t - math.asin(0.5) / 20) * 20 / (2 * math.pi)),
    ),
    rule(
        "3.7.5 change of a Boolean",
        "model M Boolean b = cos(20*time) > 0; Integer y(start=0, fixed=true); equation\n"
        "when change(b) then y = pre(y) + 1; end when; end M;",
        y=lambda t: math.floor(20 * t / math.pi + 0.5),
    ),
    rule(
        "3.7.5 change of an Integer",
        "model M Integer k = integer(5*time); Integer y(start=0, fixed=true); equation\n"
        "when change(k) then y = pre(y) + k; end when; end M;",
        y=lambda t: sum(range(math.floor(5 * t + 1e-12) + 1)),
    ),
    rule(
        "3.7.5 edge of not",
        "model M Boolean b = time < 0.4; Integer y(start=0, fixed=true); equation\n"
        "when not b then y = pre(y) + 1; end when; end M;",
        y=step(0.4, 0, 1),
    ),
    rule(
        "3.7.5 reinit of one state of two",
        "model M Real x(start=0, fixed=true); Real y(start=0, fixed=true); equation der(x) = 1; der(y) = 2;\n"
        "when x > 0.4 then reinit(y, -1); end when; end M;",
        y=lambda t: 2 * t if t < 0.4 else -1 + 2 * (t - 0.4),
        x=ramp(1),
    ),
    rule(
        "3.7.5 reinit with the value before",
        "model M Real x(start=1, fixed=true); equation der(x) = -x; when time >= 0.5 then reinit(x, 2*pre(x) + 1);\n"
        "end when; end M;",
        x=lambda t: math.exp(-t) if t < 0.5 else (2 * math.exp(-0.5) + 1) * math.exp(0.5 - t),
    ),
    rule(
        "3.7.5 smooth and its events",
        "model M Real s(start=-0.5, fixed=true); Real y = smooth(1, if s > 0 then s^2 else 0); equation der(s) = 1;"
        " end M;",
        y=lambda t: max(t - 0.5, 0) ** 2,
    ),
    rule(
        "3.8.2 an Integer parameter in Real arithmetic",
        "model M parameter Integer n = 3; parameter Integer m = 2; Real y = n/m + time; end M;",
        y=lambda t: 1.5 + t,
    ),
    rule(
        "3.8.4 a discrete-time expression of a continuous one",
        "model M Real x = 2*time; Boolean b = x > 1; Integer k = if b then 3 else 4; Real y = k; end M;",
        y=step(0.5, 4, 3),
    ),
    rule(
        "3.7.2 mod of a negative argument in a function",
        "function own input Real x; output Real y; algorithm y := mod(x - 0.5, 0.4) + 10*rem(x - 0.5, 0.4); end own;\n"
        "model M Real y = own(time); end M;",
        y=lambda t: (t - 0.5) % 0.4 + 10 * math.fmod(t - 0.5, 0.4),
    ),
    rule(
        "3.7.5 not sample becomes true in the next iteration",
        "model M Boolean s = sample(0.05, 0.1); Integer y(start=0, fixed=true); equation\n"
        "when not s then y = pre(y) + 1; end when; end M;",
        y=lambda t: math.floor((t - 0.05) / 0.1 + 1e-9) + 1,
    ),
    rule(
        "3.7.5 sample is true in one iteration only",
        "model M Boolean s = sample(0.05, 0.1); Boolean z(start=false, fixed=true); Real y = if z then 1 else 0; equation\n"
        "when s then z = true; elsewhen not s then z = false; end when; end M;",
        y=constant(0),
    ),
]
