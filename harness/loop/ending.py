"""When things happen in a loop, and how it ends; the same for every engine."""

from collections.abc import Sequence
from dataclasses import dataclass

from railgrip.trace.outcome import Outcome


@dataclass(frozen=True, slots=True, kw_only=True)
class Clock:
    """Integer time: everything happens at whole multiples of the communication period.

    Attributes:
        period: Communication period [s].
        estimator: Communication periods between two steps of the estimator.
        controller: The same for the controller.
        samples: Communication periods until the horizon.
        sensors: Communication periods between two readings; in between there is nothing new.
    """

    period: float
    estimator: int
    controller: int
    samples: int
    sensors: int = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Ending:
    """How a run of the loop ended.

    Attributes:
        outcome: The kind of end.
        reason: In one sentence.
        samples: Rows written.
    """

    outcome: Outcome
    reason: str
    samples: int


def standstill(distance: float, time: float, samples: int) -> Ending:
    """Return the end of a stop: after so many metres and seconds."""
    reason = f"Stopped after {distance:.2f} m and {time:.3f} s."
    return Ending(outcome=Outcome.STANDSTILL, reason=reason, samples=samples)


def horizon(speed: float, distance: float, clock: Clock, samples: int) -> Ending:
    """Return the end of a run that reached its horizon with a speed [m/s]."""
    reason = f"Still moving at {speed:.2f} m/s after {clock.samples * clock.period:g} s and {distance:.1f} m."
    return Ending(outcome=Outcome.HORIZON, reason=reason, samples=samples)


def divergence(problem: str, time: float, samples: int) -> Ending:
    """Return the end of a run whose estimator failed with `problem`, a sentence."""
    return Ending(outcome=Outcome.DIVERGED, reason=f"{problem} At {time:.3f} s.", samples=samples)


def implausibility(problem: str, samples: int) -> Ending:
    """Return the end of a run whose plant showed what cannot be, `problem` in a sentence."""
    return Ending(outcome=Outcome.IMPLAUSIBLE, reason=problem, samples=samples)


def without_reading(problem: str, samples: int) -> Ending:
    """Return the end of a run whose sensors failed with `problem`, a sentence."""
    return Ending(outcome=Outcome.SENSORS_FAILED, reason=problem, samples=samples)


def without_controller(problem: str, samples: int) -> Ending:
    """Return the end of a run whose controller failed with `problem`, a sentence."""
    return Ending(outcome=Outcome.CONTROLLER_FAILED, reason=problem, samples=samples)


def without_command(command: Sequence[float], time: float, samples: int) -> Ending:
    """Return the end of a run whose controller gave something else than numbers."""
    reason = f"The controller's command at {time:.3f} s is {tuple(command)}, not {len(command)} numbers."
    return Ending(outcome=Outcome.CONTROLLER_FAILED, reason=reason, samples=samples)
