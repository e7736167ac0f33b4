"""Solutions that rules.mo compares with, computed without the compiler."""

import math
from functools import cache

import numpy as np
from corpus.case import Function
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

A = np.array([[1.0, 2.0], [3.0, 4.0]])


def solve(t: float) -> np.ndarray:
    """Return x of (A + t I) x = [1, 2]."""
    return np.linalg.solve(A + t * np.eye(2), [1.0, 2.0])


def bounces(t: float) -> tuple[float, float]:
    """Return height and number of impacts of a ball that falls from 0.5 m and keeps 0.8 of its speed."""
    g, impact = 9.81, math.sqrt(2 * 0.5 / 9.81)
    if t < impact:
        return 0.5 - g * t * t / 2, 0
    speed, begin, count = 0.8 * g * impact, impact, 1
    while t >= begin + 2 * speed / g:
        begin, speed, count = begin + 2 * speed / g, 0.8 * speed, count + 1
    return speed * (t - begin) - g * (t - begin) ** 2 / 2, count


def hysteresis(t: float) -> float:
    """Return x of der(x) = 5 while it rises to 1, and -5 while it falls to 0.2, from 0.2."""
    phase = t % 0.32
    return 0.2 + 5 * phase if phase < 0.16 else 1.0 - 5 * (phase - 0.16)


@cache
def pendulum() -> Function:
    """Return the height of a pendulum of 10 m that starts at 3-4-5 from the vertical, by its angle."""
    solution = solve_ivp(
        lambda t, s: [s[1], -0.981 * math.sin(s[0])], (0, 1.1), [math.asin(0.6), 0], rtol=1e-11, atol=1e-12,
        dense_output=True,
    )  # fmt: skip
    return lambda t: -10 * math.cos(float(solution.sol(t)[0]))


def stick_slip() -> Function:
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
