"""How much less a train brakes on wet rail: K_wet_rst of ETCS, from stops on dry and on wet rail.

K_wet_rst = 100/(100 + increase of the deceleration distance in %), where the deceleration distance is the stopping
distance less the distance travelled in the equivalent build-up time (SUBSET-040; stops as of EN 15595, tests 1 and 3,
or 2 and 4: verify in the standards).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, sqrt

import numpy as np

from railgrip.base.arrays import Array


@dataclass(frozen=True, slots=True)
class Interval:
    """An estimate, and the interval that holds the truth with some confidence."""

    value: float
    low: float
    high: float


def equivalent_time(time: Array, pressure: Array) -> float:
    """Return the time after which full pressure at once would brake as much as this build-up [s].

    Args:
        time: Since the brake demand, shape (n,) [s].
        pressure: Of the cylinders in a stop on dry rail, shape (n,) or (n, groups), any unit.

    Raises:
        ValueError: The pressure at the end is 0.
    """
    mean = pressure.reshape(len(time), -1).mean(axis=1)
    if mean[-1] <= 0:
        raise ValueError("the equivalent time needs a stop that ends under pressure")
    return float(np.trapezoid(1.0 - mean / mean[-1], time))


def corrected_distance(distance: float, speed: float, nominal_speed: float, time: float) -> float:
    """Return the stopping distance from the nominal speed [m], of a stop from about that speed.

    v_n t_e + (s − v t_e)(v_n/v)², the leading terms of EN 16834.

    Args:
        distance: Of the stop [m].
        speed: At its brake demand [m/s].
        nominal_speed: At which it was to be [m/s].
        time: Equivalent time of the brake [s].
    """
    return nominal_speed * time + (distance - speed * time) * (nominal_speed / speed) ** 2


def deceleration_distance(distance: float, speed: float, time: float) -> float:
    """Return a stopping distance [m] less the distance travelled at `speed` [m/s] in the equivalent time [s]."""
    return distance - speed * time


def k_wet_of_distances(dry: float, wet: float, speed: float, time: float) -> float:
    """Return K_wet_rst of a stopping distance on dry and one on wet rail [m], from one speed [m/s]."""
    return deceleration_distance(dry, speed, time) / deceleration_distance(wet, speed, time)


def k_wet(dry: Sequence[float], wet: Sequence[float], speed: float, time: float, confidence: float = 0.95) -> Interval:
    """Return K_wet_rst of stops from one speed.

    The interval is Welch's, of the logarithms of the two means: distances of one kind scatter by a few percent.

    Args:
        dry: Stopping distances on dry rail, two or more, corrected to the speed [m].
        wet: The same on wet rail.
        speed: At the brake demand [m/s].
        time: Equivalent time of the brake [s].
        confidence: Of the interval.

    Raises:
        ValueError: Less than two stops of a kind, or one shorter than the equivalent time alone.
    """
    means: list[float] = []
    variances: list[float] = []
    freedom: list[int] = []
    for name, distances in (("dry", dry), ("wet", wet)):
        braking_distance = np.array([deceleration_distance(distance, speed, time) for distance in distances])
        if len(braking_distance) < 2 or not np.isfinite(braking_distance).all() or braking_distance.min() <= 0:
            raise ValueError(
                f"K_wet needs at least two {name} stops, each longer than the {speed * time:.4g} m of the equivalent "
                f"time, got {list(distances)}"
            )
        means.append(float(braking_distance.mean()))
        variances.append(float(braking_distance.var(ddof=1)) / len(braking_distance) / means[-1] ** 2)
        freedom.append(len(braking_distance) - 1)
    both = sum(variances)
    value = k_wet_of_distances(float(np.mean(dry)), float(np.mean(wet)), speed, time)
    half = 0.0
    if both > 0.0:
        count = both**2 / sum(variance**2 / n for variance, n in zip(variances, freedom, strict=True))
        from scipy.special import stdtrit  # see `railgrip.scenario.conditioning`

        half = float(stdtrit(count, (1 + confidence) / 2)) * sqrt(both)
    return Interval(value, value * exp(-half), value * exp(half))
