"""Chapter 8 of the Modelica Language Specification, 3.6: equations, events, initialization."""

import math

import numpy as np
from corpus.case import Function, constant, ramp, rule, step
from scipy.integrate import solve_ivp
from scipy.optimize import brentq


def _bounces(t: float) -> tuple[float, float]:
    """Return height and number of impacts of a ball that falls from 0.5 m and keeps 0.8 of its speed."""
    g, impact = 9.81, math.sqrt(2 * 0.5 / 9.81)
    if t < impact:
        return 0.5 - g * t * t / 2, 0
    speed, begin, count = 0.8 * g * impact, impact, 1
    while t >= begin + 2 * speed / g:
        begin, speed, count = begin + 2 * speed / g, 0.8 * speed, count + 1
    return speed * (t - begin) - g * (t - begin) ** 2 / 2, count


def _hysteresis(t: float) -> float:
    """Return x of der(x) = 5 while it rises to 1, and -5 while it falls to 0.2, from 0.2."""
    phase = t % 0.32
    return 0.2 + 5 * phase if phase < 0.16 else 1.0 - 5 * (phase - 0.16)


def _pendulum() -> Function:
    """Return the height of a pendulum of 10 m that starts at 3-4-5 from the vertical, by its angle."""
    solution = solve_ivp(
        lambda t, s: [s[1], -0.981 * math.sin(s[0])], (0, 1.1), [math.asin(0.6), 0], rtol=1e-11, atol=1e-12,
        dense_output=True,
    )  # fmt: skip
    return lambda t: -10 * math.cos(float(solution.sol(t)[0]))


def _stick_slip() -> Function:
    """Return the position of a mass on a belt: it sticks until the spring has reached the friction, then it slides."""
    c, v, stick, slide = 10.0, 1.0, 4.0, 2.0
    begin = stick / (c * v)
    w = math.sqrt(c)
    # x'' = slide - c x with x = stick/c and x' = v at first; it sticks again when its speed is that of the belt.
    a, b = (stick - slide) / c, v / w
    again = 2 * (math.pi - math.atan2(a, b)) / w  # the time at which the speed is v once more
    end = brentq(lambda s: -a * w * math.sin(w * s) + b * w * math.cos(w * s) - v, 0.5 * again, 1.2 * again)

    def position(t: float) -> float:
        if t < begin:
            return v * t
        s = t - begin
        assert s < end
        return slide / c + a * math.cos(w * s) + b * math.sin(w * s)

    return position


RULES = [
    rule(
        "8.3.1 equations in any order and form",
        "model M Real a; Real b; Real y; equation 2*a + b = y; b = 3; a - time = b; end M;",
        y=lambda t: 2 * (t + 3) + 3,
    ),
    rule(
        "8.3.1 an equation between arrays",
        "model M Real a[3]; Real b[3] = {1, 2, 3}; Real y = a[2]; equation a - b = {time, time, 0}; end M;",
        y=lambda t: 2 + t,
    ),
    rule(
        "8.3.1 several results of a function",
        "model M Real r; Real phi; Real y = r; equation (r, phi) = Shared.polar(time); end M;",
        y=lambda t: math.hypot(t, 1),
        phi=lambda t: math.atan2(1, t),
    ),
    rule(
        "8.3.1 a result that is left out",
        "model M Real y; equation (, y) = Shared.polar(time + 1); end M;",
        y=lambda t: math.atan2(1, t + 1),
    ),
    rule(
        "8.3.2 for equations",
        "model M Real x[4]; Real y = x[4]; equation x[1] = time; for i in 2:4 loop x[i] = 2*x[i - 1]; end for; end M;",
        y=ramp(8),
    ),
    rule(
        "8.3.2 nested for equations",
        "model M Real x[2, 3]; Real y = x[2, 3] + 10*x[1, 2]; equation for i in 1:2 loop for j in 1:3 loop\n"
        "x[i, j] = i*time + j; end for; end for; end M;",
        y=lambda t: 2 * t + 3 + 10 * (t + 2),
    ),
    rule(
        "8.3.2 a for equation with two iterators",
        "model M Real x[2, 3]; Real y = x[2, 3]; equation for i in 1:2, j in 1:3 loop x[i, j] = i*time + j; end for;"
        " end M;",
        y=lambda t: 2 * t + 3,
    ),
    rule(
        "8.3.2 for equations over other ranges",
        "model M Real x[6]; Real y = sum(x); equation for i in 1:2:5 loop x[i] = time; end for;\n"
        "for i in {2, 6} loop x[i] = 2*time; end for; for i in 4:-1:4 loop x[i] = 1; end for; end M;",
        y=lambda t: 7 * t + 1,
    ),
    rule(
        "8.3.2 a for equation over the size of an array",
        "model M parameter Integer n = 3; Real x[n]; Real y = sum(x); equation for i loop x[i] = i*time; end for; end M;",
        y=ramp(6),
    ),
    rule(
        "8.3.2 a for equation that never runs",
        "model M Real y; equation y = time; for i in 2:1 loop y = 1; end for; end M;",
        y=ramp(1),
    ),
    rule(
        "8.3.3 connect in a for equation",
        "connector C Real e; flow Real f; end C; model R C a; C b; equation a.f + b.f = 0; a.e - b.e = a.f; end R;\n"
        "model M R r[3]; Real y = r[1].a.f; equation for i in 1:2 loop connect(r[i].b, r[i + 1].a); end for;\n"
        "r[1].a.e = 6*time; r[3].b.e = 0; end M;",
        y=ramp(2),
    ),
    rule(
        "8.3.4 an if equation with events",
        "model M Real x(start=0, fixed=true); Real y; equation der(x) = 2; if x > 1 then y = 1; elseif x > 0.5 then\n"
        "y = 2*x; else y = 3; end if; end M;",
        y=lambda t: 3 if t <= 0.25 else 4 * t if t <= 0.5 else 1,
    ),
    rule(
        "8.3.4 branches that give different equations",
        "model M Real a; Real b; Real y = a + 10*b; equation if time < 0.5 then a = 1; b = 2*a; else b = time;\n"
        "a = b + 1; end if; end M;",
        y=lambda t: 21 if t < 0.5 else 11 * t + 1,
    ),
    rule(
        "8.3.4 an if equation of a parameter with different numbers of unknowns",
        "model M parameter Boolean has = false; Real y; equation if has then y = 1; else y = 2*time; end if; end M;",
        y=ramp(2),
    ),
    rule(
        "8.3.5 when with a state event",
        "model M Real x(start=0, fixed=true); discrete Real y(start=0, fixed=true); equation der(x) = 1 + x;\n"
        "when x > 0.5 then y = x + time; end when; end M;",
        y=step(math.log(1.5), 0, 0.5 + math.log(1.5)),
    ),
    rule(
        "8.3.5 when with time >",
        "model M Integer y(start=0, fixed=true); equation when time > 0.4 then y = 7; end when; end M;",
        y=step(0.4, 0, 7),
    ),
    rule(
        "8.3.5 when with time >=",
        "model M Integer y(start=0, fixed=true); equation when time >= 0.4 then y = 7; end when; end M;",
        y=step(0.4, 0, 7),
    ),
    rule(
        "8.3.5 a condition that is true at the start makes no edge",
        "model M Integer y(start=0, fixed=true); equation when time >= 0 then y = 7; end when; end M;",
        y=constant(0),
    ),
    rule(
        "8.3.5 elsewhen",
        "model M Real x(start=0, fixed=true); Integer y(start=0, fixed=true); equation der(x) = 1;\n"
        "when x > 0.7 then y = 3; elsewhen x > 0.4 then y = 2; elsewhen x > 0.1 then y = 1; end when; end M;",
        y=lambda t: 0 if t < 0.1 else 1 if t < 0.4 else 2 if t < 0.7 else 3,
    ),
    rule(
        "8.3.5 the first of two branches at one instant",
        "model M Integer y(start=0, fixed=true); equation when sample(0.2, 0.4) then y = pre(y) + 10;\n"
        "elsewhen sample(0.2, 0.2) then y = pre(y) + 1; end when; end M;",
        y=lambda t: sum(10 if k % 2 == 1 else 1 for k in range(1, math.floor(5 * t + 1e-9) + 1)),
    ),
    rule(
        "8.3.5 when with several conditions",
        "model M Integer y(start=0, fixed=true); equation when {time > 0.3, time > 0.6} then y = pre(y) + 1; end when;"
        " end M;",
        y=lambda t: 0 if t < 0.3 else 1 if t < 0.6 else 2,
    ),
    rule(
        "8.3.5 when with initial() among the conditions",
        "model M Integer y(start=0); equation when {initial(), time > 0.6} then y = pre(y) + 1; end when; end M;",
        y=step(0.6, 1, 2),
    ),
    rule(
        "8.3.5 a condition of and and or",
        "model M Real x(start=0, fixed=true); Integer y(start=0, fixed=true); equation der(x) = 1;\n"
        "when x > 0.2 and time > 0.5 or x > 0.8 then y = pre(y) + 1; end when; end M;",
        y=step(0.5, 0, 1),
    ),
    rule(
        "8.3.5 equations of one when clause are solved in any order",
        "model M discrete Real y(start=0, fixed=true); discrete Real a(start=0, fixed=true); equation\n"
        "when time > 0.5 then y = 2*a; a = 3; end when; end M;",
        y=step(0.5, 0, 6),
    ),
    rule(
        "8.3.5 one when clause triggers another",
        "model M Integer a(start=0, fixed=true); Integer y(start=0, fixed=true); equation\n"
        "when time > 0.5 then a = 2; end when; when a > 1 then y = pre(y) + a; end when; end M;",
        y=step(0.5, 0, 2),
    ),
    rule(
        "8.3.5 the next event is calculated in a when clause",
        "model M discrete Real next(start=0.1, fixed=true); Integer y(start=0, fixed=true); equation\n"
        "when time >= pre(next) then next = pre(next) + 0.25; y = pre(y) + 1; end when; end M;",
        y=lambda t: 0 if t < 0.1 else 1 + math.floor((t - 0.1) / 0.25 + 1e-9),
    ),
    rule(
        "8.3.6 reinit: a bouncing ball",
        "model M Real h(start=0.5, fixed=true); Real v(start=0, fixed=true); Integer n(start=0, fixed=true); equation\n"
        "der(h) = v; der(v) = -9.81; when h < 0 and v < 0 then reinit(v, -0.8*pre(v)); n = pre(n) + 1; end when; end M;",
        h=lambda t: _bounces(t)[0],
        n=lambda t: _bounces(t)[1],
    ),
    rule(
        "8.3.6 reinit at a time event without discrete variables",
        "model M Real x(start=1, fixed=true); equation der(x) = -1; when sample(0.25, 0.5) then reinit(x, 5); end when;"
        " end M;",
        x=lambda t: 1 - t if t < 0.25 else 5 - (t - 0.25) if t < 0.75 else 5 - (t - 0.75),
    ),
    rule(
        "8.3.6 reinit in one of two branches",
        "model M Real x(start=0, fixed=true); equation der(x) = 1; when x > 0.6 then reinit(x, 0);\n"
        "elsewhen time > 0.3 then reinit(x, 0.5); end when; end M;",
        x=lambda t: t if t < 0.3 else 0.5 + (t - 0.3) if t < 0.4 else (t - 0.4) % 0.6,
    ),
    rule(
        "8.3.7 an assertion that holds",
        'model M Real y = time; equation assert(y < 2, "y is " + String(y)); end M;',
        y=ramp(1),
    ),
    rule(
        "8.3.7 an assertion of level warning",
        'model M Real y = time; equation assert(y < 0.5, "y is large", AssertionLevel.warning); end M;',
        y=ramp(1),
    ),
    rule(
        "8.3.8 terminate",
        'model M Real y = time; equation when time > 5 then terminate("late"); end when; end M;',
        y=ramp(1),
    ),
    rule(
        "8.4 a chain of Boolean equations at an event",
        "model M Boolean a = time > 0.5; Boolean b = not a; Boolean c = not b; Boolean d = a and c;\n"
        "Real y = if d then 1 else 0; end M;",
        y=step(0.5, 0, 1),
    ),
    rule(
        "8.5 hysteresis with pre",
        "model M Real x(start=0.2, fixed=true); Boolean up(start=true, fixed=true); equation der(x) = if up then 5 else -5;\n"
        "up = pre(up) and x < 1 or x < 0.2; end M;",
        x=_hysteresis,
    ),
    rule(
        "8.5 a stick-slip oscillator",
        "model M parameter Real v = 1; Real x(start=0, fixed=true); Real w(start=1, fixed=true);\n"
        "Boolean slides(start=false, fixed=true); equation slides = 10*x > 4 or pre(slides) and w < v;\n"
        "der(x) = w; der(w) = if slides then 2 - 10*x else 0; end M;",
        x=_stick_slip(),
    ),
    rule(
        "8.5 two events at one instant",
        "model M Real a(start=0, fixed=true); Real b(start=1, fixed=true); Integer y(start=0, fixed=true);\n"
        "Integer n(start=0, fixed=true); equation der(a) = 1; der(b) = -1; when a > 0.5 then y = pre(y) + 1; end when;\n"
        "when b < 0.5 then n = pre(n) + 1; end when; end M;",
        y=step(0.5, 0, 1),
        n=step(0.5, 0, 1),
    ),
    rule(
        "8.5 a relation that changes twice within three output intervals",
        "model M Real x(start=0, fixed=true); Integer y(start=0, fixed=true); equation der(x) = 1;\n"
        "when abs(x - 0.5) < 0.02 then y = pre(y) + 1; end when; end M;",
        y=step(0.48, 0, 1),
    ),
    rule(
        "8.6 initial equations",
        "model M Real x; Real v; equation der(x) = v; der(v) = -x; initial equation x + v = 3; x - v = 1; end M;",
        x=lambda t: 2 * math.cos(t) + math.sin(t),
    ),
    rule(
        "8.6 a steady start",
        "model M Real x; Real u = 3 + time; initial equation der(x) = 0; equation der(x) = u - x; end M;",
        x=lambda t: 2 + t + math.exp(-t),
    ),
    rule(
        "8.6 an initial equation for an algebraic variable",
        "model M Real x; Real y = 2*x; initial equation y = 6; equation der(x) = -x; end M;",
        y=lambda t: 6 * math.exp(-t),
    ),
    rule(
        "8.6 fixed of an algebraic variable",
        "model M Real x(start=1); Real y(start=6, fixed=true) = 2*x; equation der(x) = -x; end M;",
        y=lambda t: 6 * math.exp(-t),
    ),
    rule(
        "8.6 a nonlinear initial equation",
        "model M Real x(start=1); initial equation x^3 + x = 10; equation der(x) = 1; end M;",
        x=lambda t: 2 + t,
    ),
    rule(
        "8.6 a start value is the value of a state without another condition",
        "model M Real x(start=2); equation der(x) = -x; end M;",
        x=lambda t: 2 * math.exp(-t),
    ),
    rule(
        "8.6 a parameter with fixed=false",
        "model M parameter Real k(fixed=false, start=1); Real x(start=1, fixed=true); initial equation der(x) = -3;\n"
        "equation der(x) = -k*x; end M;",
        x=lambda t: math.exp(-3 * t),
    ),
    rule(
        "8.6 an initial equation for a discrete variable",
        "model M discrete Real y; initial equation y = 4; equation when time > 0.5 then y = pre(y) + 1; end when; end M;",
        y=step(0.5, 4, 5),
    ),
    rule(
        "8.6 an initial equation for pre",
        "model M Integer y; initial equation pre(y) = 4; equation when time > 0.5 then y = pre(y) + 1; end when; end M;",
        y=step(0.5, 4, 5),
    ),
    rule(
        "8.6 an initial if equation",
        "model M parameter Boolean steady = false; Real x; initial equation if steady then der(x) = 0; else x = 2; end if;\n"
        "equation der(x) = 1; end M;",
        x=lambda t: 2 + t,
    ),
    rule(
        "8 a linear system of three equations",
        "model M Real a; Real b; Real c; Real y = a + 10*b + 100*c; equation a + b + c = 6*time; a - b = -time;\n"
        "b + 2*c = 8*time; end M;",
        y=lambda t: float(np.linalg.solve([[1, 1, 1], [1, -1, 0], [0, 1, 2]], [6 * t, -t, 8 * t]) @ [1, 10, 100]),
    ),
    rule(
        "8 a linear system whose matrix varies",
        "model M Real a; Real b; Real y = a + b; equation (1 + time)*a + b = 1; a - time*b = 2; end M;",
        y=lambda t: float(np.sum(np.linalg.solve([[1 + t, 1], [1, -t]], [1, 2]))),
    ),
    rule(
        "8 a system of two nonlinear equations",
        "model M Real a(start=1); Real b(start=1); Real y = a; equation a^2 + b^2 = 4 + time; a = exp(-b) + b; end M;",
        y=lambda t: (lambda b: math.exp(-b) + b)(
            brentq(lambda b: (math.exp(-b) + b) ** 2 + b * b - 4 - t, 0.5, 3, xtol=1e-14)
        ),
    ),
    rule(
        "8 derivatives in an implicit equation",
        "model M Real x(start=0, fixed=true); Real d(start=1); equation d + d^3 = 2 + time; d = der(x); end M;",
        d=lambda t: brentq(lambda d: d + d**3 - 2 - t, 0, 3, xtol=1e-14),
    ),
    rule(
        "8 index reduction: two masses that move as one",
        "model M Real a(start=1, fixed=true); Real b; Real v(start=2, fixed=true); Real w; Real f; Real y = b; equation\n"
        "der(a) = v; der(b) = w; der(v) = f; 2*der(w) = 3 - f; a = b; end M;",
        y=lambda t: 1 + 2 * t + 0.5 * t * t,
    ),
    rule(
        "8 index reduction: a pendulum in Cartesian coordinates",
        "model M Real x(start=6, fixed=true); Real z(start=-8); Real u(start=0, fixed=true); Real w; Real f; Real y = z;\n"
        "equation der(x) = u; der(z) = w; der(u) = -f*x; der(w) = -f*z - 9.81; x^2 + z^2 = 100; end M;",
        y=_pendulum(),
    ),
    rule(
        "8 index reduction with a driven position",
        "model M Real x; Real v; Real f; Real y = f; equation x = sin(2*time); der(x) = v; 3*der(v) = f; end M;",
        y=lambda t: -12 * math.sin(2 * t),
    ),
    rule(
        "8 a stiff decay",
        "model M Real x(start=2, fixed=true); Real y(start=0, fixed=true); equation der(x) = -1000*(x - time);\n"
        "der(y) = x; end M;",
        y=lambda t: t * t / 2 - 1e-3 * t + (2 + 1e-3) / 1000 * (1 - math.exp(-1000 * t)),
    ),
    rule(
        "8 an oscillator",
        "model M Real x(start=1, fixed=true); Real v(start=0, fixed=true); equation der(x) = v; der(v) = -100*x; end M;",
        x=lambda t: math.cos(10 * t),
    ),
    rule(
        "8.3.2 a range that depends on the outer iterator",
        "model M Real v[4] = {1, 2, 3, 4}*time; Real x[4]; Real y = x[4] + 10*x[2]; equation x[1] = 0;\n"
        "for i in 2:4 loop x[i] = sum({v[j] for j in 1:i - 1}); end for; end M;",
        y=ramp(16),
    ),
    rule(
        "8.3.5 a table that a discrete index reads",
        "model M parameter Real v[4] = {0.2, 0.5, 0.6, 5}; Integer i(start=1, fixed=true);\n"
        "discrete Real y(start=0.2, fixed=true); equation when time > pre(y) then i = pre(i) + 1; y = v[i]; end when; end M;",
        y=lambda t: 0.2 if t < 0.2 else 0.5 if t < 0.5 else 0.6 if t < 0.6 else 5,
    ),
    rule(
        "8.3.5 elsewhen in an algorithm",
        "model M Integer y(start=0, fixed=true); algorithm when time > 0.3 then y := 1; elsewhen time > 0.6 then y := 2;\n"
        "end when; end M;",
        y=lambda t: 0 if t < 0.3 else 1 if t < 0.6 else 2,
    ),
]
