"""Places in a class where an expression may be, each as the text of a class `M` with an output y (contexts.mo)."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from corpus.case import Function, paragraphs
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


def _parameter_and_time(formula: Formula, signal: Function, value: float) -> Function:
    return lambda t: formula(value) + t


def _initial_and_time(formula: Formula, signal: Function, value: float) -> Function:
    return lambda t: formula(signal(0.0)) + t


def _branches(formula: Formula, signal: Function, value: float) -> Function:
    return lambda t: formula(signal(t)) if t < 0.55 else 1 - formula(signal(t))


def _condition(formula: Formula, signal: Function, value: float) -> Function:
    return lambda t: 1.0 if formula(signal(t)) > THRESHOLD else 0.0


def _context(comment: str, text: str) -> tuple[str, Context]:
    name, expected, *options = comment.split("; ")
    tolerance = next((float(option.removeprefix("tolerance = ")) for option in options if "=" in option), 1e-5)
    return name, Context(text, globals()[f"_{expected}"], "smooth" in options, tolerance)


CONTEXTS = dict(_context(*paragraph) for paragraph in paragraphs("contexts.mo"))
"""Name → context. The comment above a context has its name, its function in this file, and what is not default."""
