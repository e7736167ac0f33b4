"""Places in a class where an expression may be, each as the text of a class `M` with an output y."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from corpus.case import Function
from corpus.features import Formula

SIGNALS: Mapping[str, tuple[str, Function]] = {
    "wave": ("0.7 + 1.9*sin(3*time + 0.4)", lambda t: 0.7 + 1.9 * math.sin(3 * t + 0.4)),
    "positive": ("1.5 + 0.9*sin(3*time + 0.4)", lambda t: 1.5 + 0.9 * math.sin(3 * t + 0.4)),
    "unit": ("0.8*sin(3*time + 0.4)", lambda t: 0.8 * math.sin(3 * t + 0.4)),
}
"""Names of domains → signal in Modelica and Python. The wave has values from −1.2 to 2.6."""

VALUE: Mapping[str, float] = {"wave": 1.3, "positive": 1.3, "unit": -0.6}
"""Values of parameters in these domains."""


@dataclass(frozen=True, slots=True)
class Context:
    """A place of an expression.

    Attributes:
        text: Body of a package with the class M. In it `SIGNAL` is the signal, `SIGNAL_OF(s)` the same of another
            variable than time, `VALUE` the value of the parameter, and `E(x)` the expression with the Real x.
        expected: Function of (formula, signal, value) that returns y over time.
        smooth: Whether the expression must be differentiable.
        tolerance: See `Case`.
    """

    text: str
    expected: Callable[[Formula, Function, float], Function]
    smooth: bool = False
    tolerance: float = 1e-5


def _signal(formula: Formula, signal: Function, value: float) -> Function:
    return lambda t: formula(signal(t))


def _parameter(formula: Formula, signal: Function, value: float) -> Function:
    return lambda t: formula(value)


def _sampled(formula: Formula, signal: Function, value: float) -> Function:
    # sample(0.1, 0.2); the offset is less than any distance of two samples from each other.
    return lambda t: formula(signal(0.1 + 0.2 * math.floor((t - 0.1) / 0.2 + 1e-9))) if t >= 0.1 else 0.0


def _integrated(formula: Formula, signal: Function, value: float) -> Function:
    # The midpoint rule: the error of a jump is below its height times the step.
    step = 2e-5

    @cache
    def table() -> tuple[np.ndarray, np.ndarray]:
        middles = np.arange(0.5 * step, 1.1, step)
        total = np.concatenate([[0.0], np.cumsum([formula(signal(t)) for t in middles]) * step])
        return np.arange(len(total)) * step, total

    return lambda t: float(np.interp(t, *table()))


def _differentiated(formula: Formula, signal: Function, value: float) -> Function:
    def slope(t: float, h: float) -> float:
        return (formula(signal(t + h)) - formula(signal(t - h))) / (2 * h)

    return lambda t: (4 * slope(t, 5e-4) - slope(t, 1e-3)) / 3  # Richardson: an error of fourth order


def _solved(formula: Formula, signal: Function, value: float) -> Function:
    def solution(t: float) -> float:
        y, right = 0.0, formula(signal(t))
        for _ in range(60):  # Newton: y + y^3/3 is monotonous
            y -= (y + y**3 / 3 - right) / (1 + y * y)
        return y

    return solution


def _counted(formula: Formula, signal: Function, value: float) -> Function:
    """Return how often the expression has risen above the threshold."""

    @cache
    def table() -> tuple[np.ndarray, np.ndarray]:
        grid = np.arange(0.0, 1.1, 5e-5)
        above = np.array([formula(signal(t)) > THRESHOLD for t in grid])
        return grid, np.concatenate([[0], np.cumsum(above[1:] & ~above[:-1])])

    def count(t: float) -> float:
        grid, counts = table()
        return float(counts[np.searchsorted(grid, t, side="right") - 1])

    return count


THRESHOLD = 0.61
"""Value that a condition compares an expression with; no expression keeps it or only touches it."""

CONTEXTS = {
    "equation": Context("model M Real x; Real y; equation x = SIGNAL; y = E(x); end M;", _signal),
    "equation the other way round": Context("model M Real x; Real y; equation E(x) = y; SIGNAL = x; end M;", _signal),
    "binding": Context("model M Real x = SIGNAL; output Real y = E(x); end M;", _signal),
    "protected variable": Context(
        "model M Real x = SIGNAL; Real y = z; protected Real z = E(x); end M;", _signal
    ),
    "state": Context(
        "model M Real x = SIGNAL; Real y(start=0, fixed=true); equation der(y) = E(x); end M;", _integrated, tolerance=1e-4
    ),
    "of a state": Context(
        "model M Real s(start=0, fixed=true); Real x; Real y; equation der(s) = 1; x = SIGNAL_OF(s); y = E(x); end M;",
        _signal,
    ),
    "derivative": Context("model M Real x = SIGNAL; Real z = E(x); Real y = der(z); end M;", _differentiated, True, 1e-4),
    "parameter": Context("model M parameter Real p = VALUE; parameter Real q = E(p); Real y = q; end M;", _parameter),
    "final parameter": Context(
        "model M parameter Real p = VALUE; final parameter Real q = E(p); Real y = q; end M;", _parameter
    ),
    "constant": Context("model M constant Real p = VALUE; constant Real q = E(p); Real y = q; end M;", _parameter),
    "constant of a package": Context(
        "package own constant Real p = VALUE; constant Real q = E(p); end own; model M Real y = own.q; end M;", _parameter
    ),
    "start value": Context(
        "model M parameter Real p = VALUE; Real y(start=E(p), fixed=true); equation der(y) = 1; end M;",
        lambda formula, signal, value: lambda t: formula(value) + t,
    ),
    "initial equation": Context(
        "model M Real x = SIGNAL; Real y; initial equation y = E(x); equation der(y) = 1; end M;",
        lambda formula, signal, value: lambda t: formula(signal(0.0)) + t,
    ),
    "initial algorithm": Context(
        "model M Real x = SIGNAL; Real y; initial algorithm y := E(x); equation der(y) = 1; end M;",
        lambda formula, signal, value: lambda t: formula(signal(0.0)) + t,
    ),
    "when clause": Context(
        "model M Real x = SIGNAL; discrete Real y(start=0, fixed=true); equation\n"
        "when sample(0.1, 0.2) then y = E(x); end when; end M;",
        _sampled,
    ),
    "reinit": Context(
        "model M Real x = SIGNAL; Real y(start=0, fixed=true); equation der(y) = 0;\n"
        "when sample(0.1, 0.2) then reinit(y, E(x)); end when; end M;",
        _sampled,
    ),
    "algorithm": Context(
        "model M Real x = SIGNAL; Real y; Real z; algorithm z := E(x); y := z; y := y + z; y := y/2; end M;", _signal
    ),
    "when clause in an algorithm": Context(
        "model M Real x = SIGNAL; discrete Real y(start=0, fixed=true); algorithm\n"
        "when sample(0.1, 0.2) then y := E(x); end when; end M;",
        _sampled,
    ),
    "function body": Context(
        "function own input Real x; output Real y; algorithm y := E(x); end own;\n"
        "model M Real x = SIGNAL; Real y = own(x); end M;",
        _signal,
    ),
    "protected variable of a function": Context(
        "function own input Real x; output Real y; protected Real z = 2*x; Real w; algorithm w := z - x; y := E(w);\n"
        "end own; model M Real x = SIGNAL; Real y = own(x); end M;",
        _signal,
    ),
    "loop of a function": Context(
        "function own input Real x; output Real y; algorithm y := 0; for n in 1:3 loop y := y + n*(E(x)); end for;\n"
        "end own; model M Real x = SIGNAL; Real y = own(x)/6; end M;",
        _signal,
    ),
    "argument of a function": Context("model M Real x = SIGNAL; Real y = Shared.double(E(x))/2; end M;", _signal),
    "element of an array": Context(
        "model M Real x[3]; Real z[3]; Real y = z[2]; equation x = {0, SIGNAL, 0}; z[1] = 1; z[2] = E(x[2]); z[3] = 2;"
        " end M;",
        _signal,
    ),
    "array constructor": Context(
        "model M Real x = SIGNAL; Real z[3] = {1, E(x), 2}; Real y = z[2]; end M;", _signal
    ),
    "for equation": Context(
        "model M Real x[2]; Real z[2]; Real y = z[2]; equation x = {VALUE, SIGNAL};\n"
        "for n in 1:2 loop z[n] = E(x[n]); end for; end M;",
        _signal,
    ),
    "body of an array over an iterator": Context(
        "model M Real x[2] = {VALUE, SIGNAL}; Real z[2] = {E(x[n]) for n in 1:2}; Real y = z[2]; end M;", _signal
    ),
    "body of a sum over an iterator": Context(
        "model M Real x = SIGNAL; Real y = sum(n*(E(x)) for n in 1:2)/3; end M;", _signal
    ),
    "if expression": Context(
        "model M Real x = SIGNAL; Real y = if time < 0.55 then E(x) else 1 - (E(x)); end M;",
        lambda formula, signal, value: lambda t: formula(signal(t)) if t < 0.55 else 1 - formula(signal(t)),
    ),
    "if equation": Context(
        "model M Real x = SIGNAL; Real y; equation if time < 0.55 then y = E(x); else y = 1 - (E(x)); end if; end M;",
        lambda formula, signal, value: lambda t: formula(signal(t)) if t < 0.55 else 1 - formula(signal(t)),
    ),
    "if equation of a parameter": Context(
        "model M parameter Boolean b = true; Real x = SIGNAL; Real y; equation if b then y = E(x); else y = 1; end if;"
        " end M;",
        _signal,
    ),
    "inherited": Context("model B Real x = SIGNAL; Real y = E(x); end B; model M extends B; end M;", _signal),
    "inherited through two levels": Context(
        "model A Real x; Real y; end A; model B extends A; equation y = E(x); end B;\n"
        "model M extends B(x=SIGNAL); end M;",
        _signal,
    ),
    "component": Context(
        "model A input Real x; Real y = E(x); end A; model B A a(x=SIGNAL); Real y = a.y; end B;\n"
        "model M B b; Real y = b.y; end M;",
        _signal,
    ),
    "array of components": Context(
        "model A input Real x; Real y = E(x); end A; model M A a[2](x={VALUE, SIGNAL}); Real y = a[2].y; end M;",
        _signal,
    ),
    "redeclared component": Context(
        "partial model L input Real x; output Real y; end L; model A extends L; equation y = 0; end A;\n"
        "model C extends L; equation y = E(x); end C;\n"
        "model B replaceable A a constrainedby L; Real x = SIGNAL; equation a.x = x; end B;\n"
        "model M B b(redeclare C a); Real y = b.a.y; end M;",
        _signal,
    ),
    "redeclared class": Context(
        "partial model L input Real x; output Real y; end L; model A extends L; equation y = 0; end A;\n"
        "model C extends L; equation y = E(x); end C;\n"
        "model B replaceable model K = A constrainedby L; K a; Real x = SIGNAL; equation a.x = x; end B;\n"
        "model M B b(redeclare model K = C); Real y = b.a.y; end M;",
        _signal,
    ),
    "redeclared function": Context(
        "function own extends Shared.law; algorithm y := E(x); end own;\n"
        "model B replaceable function f = Shared.square constrainedby Shared.law; Real x = SIGNAL; Real y = f(x); end B;\n"
        "model M extends B(redeclare function f = own); end M;",
        _signal,
    ),
    "modifier": Context(
        "model A parameter Real q = 1; end A; model M parameter Real p = VALUE; A a(q=E(p)); Real y = a.q; end M;",
        _parameter,
    ),
    "modifier of an extends clause": Context(
        "model A parameter Real q = 1; Real y = q; end A; model M parameter Real p = VALUE; extends A(q=E(p)); end M;",
        _parameter,
    ),
    "record constructor": Context(
        "model M Real x = SIGNAL; Shared.Pair r = Shared.Pair(1, E(x)); Real y = r.b; end M;", _signal
    ),
    "field of a record": Context(
        "model M Shared.Pair r; Shared.Pair s; Real y = s.b; equation r.a = SIGNAL; r.b = 1; s.a = 0; s.b = E(r.a);"
        " end M;",
        _signal,
    ),
    "connector": Context(
        "connector In = input Real; connector Out = output Real;\n"
        "block A In x; Out y; equation y = E(x); end A; block S Out y; equation y = SIGNAL; end S;\n"
        "model M S s; A a; Real y = a.y; equation connect(s.y, a.x); end M;",
        _signal,
    ),
    "physical connector": Context(
        "connector F Real e; flow Real f; end F;\n"
        "model A F p; Real x = SIGNAL; equation p.f = -(E(x)); end A;\n"
        "model R F p; Real e = p.e; equation p.e = 2*p.f; end R;\n"
        "model M A a; R r1; R r2; Real y = r1.e + r2.p.f - r2.p.f; equation connect(a.p, r1.p); connect(r1.p, r2.p);"
        " end M;",
        _signal,
    ),
    "inner variable": Context(
        "model A outer Real x; Real y = E(x); end A; model M inner Real x = SIGNAL; A a; Real y = a.y; end M;", _signal
    ),
    "linear loop": Context(
        "model M Real x = SIGNAL; Real y; Real z; equation y + z = 3*(E(x)); y - z = -(E(x)); end M;", _signal
    ),
    "nonlinear loop": Context("model M Real x = SIGNAL; Real y(start=1); equation y + y^3/3 = E(x); end M;", _solved),
    "condition": Context(
        "model M Real x = SIGNAL; Real y = if (E(x)) > THRESHOLD then 1 else 0; end M;",
        lambda formula, signal, value: lambda t: 1.0 if formula(signal(t)) > THRESHOLD else 0.0,
    ),
    "condition of a when clause": Context(
        "model M Real x = SIGNAL; Integer y(start=0, fixed=true); equation\n"
        "when (E(x)) > THRESHOLD then y = pre(y) + 1; end when; end M;",
        _counted,
    ),
}  # fmt: skip
"""Name → context."""
