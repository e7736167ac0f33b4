"""A short run of a controller FMU, in which the wheels of one group after the other slide.

A controller that protects from sliding lowers the pressure of a group whose wheels slide. If it lowers that of another
group instead, its map has groups in another order.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from railgrip.base.arrays import Vector
from railgrip.controllers.observation import Observation
from railgrip.vehicle.brake import Brake

_SPEED = 25.0  # m/s
_DECELERATION = 1.0  # m/s2
_ROLLING, _SLIDING = 0.01, 0.6
"""Slip of wheels that roll in braking, and of wheels that slide."""
_PHASE = 0.5  # s
_LOWERED = 0.2
"""Share of the range of a decision by which a group's decision clearly changes."""


def responses(
    decide: Callable[[Observation], Sequence[float]], brakes: Sequence[Brake], period: float, *, estimates: bool
) -> NDArray[np.float64]:
    """Return how far each group's decision falls while wheels slide, over the range of all decisions.

    Row i belongs to the run in which the wheels of group i slide, shape (groups, groups). The run is that of a train at
    25 m/s that brakes with 1 m/s2; wheels roll for half a second before each slide, which lasts as long.

    Args:
        decide: Function that returns the decision for each group: a pressure, or the command to its valve.
        brakes: Brake of each group.
        period: Period of the controller [s].
        estimates: Whether the observation has estimates of adhesion and pad friction.

    Raises:
        ControllerFailed: The controller failed.
    """
    groups, steps = len(brakes), max(round(_PHASE / period), 2)
    radius, full = (np.array([getattr(brake, name) for brake in brakes]) for name in ("wheel_radius", "pressure_max"))
    samples = 0

    def phase(slip: Vector) -> Vector:
        nonlocal samples
        decisions: list[Sequence[float]] = []
        for _ in range(steps):
            time = samples * period
            speed = _SPEED - _DECELERATION * time
            adhesion = np.where(slip > _ROLLING, 0.05, 0.1)
            decisions.append(
                decide(
                    Observation(
                        time=time,
                        speed=speed,
                        acceleration=-_DECELERATION,
                        wheelset_speed=(1.0 - slip) * speed / radius,
                        slip=slip,
                        slip_is_estimated=estimates,
                        adhesion=adhesion if estimates else None,
                        pad_friction=np.full(groups, 0.35) if estimates else None,
                        pressure=full,
                        driver_demand=full,
                    )
                )
            )
            samples += 1
        return np.array(decisions)

    changes = np.zeros((groups, groups))
    lowest, highest = np.inf, -np.inf
    for group in range(groups):
        slip = np.full(groups, _ROLLING)
        before = phase(slip)
        slip = slip.copy()
        slip[group] = _SLIDING
        during = phase(slip)
        changes[group] = before[-1] - during.min(axis=0)
        lowest, highest = min(lowest, before.min(), during.min()), max(highest, before.max(), during.max())
    return changes / (highest - lowest) if highest > lowest else changes


def order_mistake(changes: NDArray[np.float64]) -> str:
    """Return the sentence on a controller that lowers the pressure of another group than the one that slides; else ''.

    A controller that lowers that of several groups, as one that takes the lowest demand for all, is not judged.
    """
    for group, change in enumerate(changes):
        lowered = np.flatnonzero(change > _LOWERED)
        if len(lowered) == 1 and lowered[0] != group:
            return (
                f"lowers the pressure of group {lowered[0] + 1} while the wheels of group {group + 1} slide; look at "
                "the order of groups, from the leading one on, in its inputs and its output"
            )
    return ""


def is_deaf(changes: NDArray[np.float64]) -> bool:
    """Return whether no slide changed any decision."""
    return bool(np.all(np.abs(changes) < _LOWERED))
