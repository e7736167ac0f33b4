"""The filters of the lateral study and what each is told.

literal        the five states of Mal et al. (2020) by forward Euler; knows the track, the condition, and a Q for it
known_track    well posed, friction a random walk; knows the track, not the condition; one Q
unknown_track  as before, and of the track only its spectrum
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from math import log
from typing import Final, Literal, get_args

import numpy as np

from railgrip.estimation.run import Kind, prediction_of
from railgrip.estimators.belief import Estimate, Vector
from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.prediction import PredictionInC
from railgrip.studies.lateral.wheelset import PAPER_SENSORS, PERIOD, Condition, Irregularity

Name = Literal["literal", "known_track", "unknown_track"]
NAMES: Final[tuple[Name, ...]] = get_args(Name)

READING_NOISE: Final = (PAPER_SENSORS[0] ** 2, PAPER_SENSORS[1] ** 2)

# What one step of 50 µs adds, for dy, dpsi, gamma, U, F; Mal et al. (2020), eq. (38) to (40).
LITERAL_NOISE: Final[Mapping[str, tuple[float, ...]]] = {
    "dry": (5e-14, 1e-14, 1e-14, 1e-14, 1e-14),
    "wet": (0.5e-12, 9e-17, 1e-12, 1e-12, 1e-12),
    "poor": (1e-13, 9e-17, 1e-12, 1e-12, 1e-12),
    "worst": (1e-13, 9e-17, 1e-12, 1e-12, 1e-12),
}

MOTION_NOISE: Final = (0.0, 1e-6**2, 0.0, 1e-7**2)
"""Density for y, dy, psi, dpsi [unit²/s]: the dynamics hold nearly exactly. Much more of it, and friction above 0.2 is
no longer told apart: a slope of the contact that is wrong by a part in a thousand looks like another friction."""

FRICTION_NOISE: Final = 0.2**2
"""Density of the random walk of the friction's logarithm [1/s]: 20 % in a second; creep must show a step."""

TRACK_DEVIATION: Final = 2.5e-3
"""Standard deviation of the track [m] that the filter of unknown track believes in: a third of the peak."""

FIRST_FRICTION: Final = (0.25, 0.6)
"""Median of mu0 and deviation of its logarithm before anything is known: from 0.08 to 0.83 with 95 %."""

FIRST_MOTION: Final = (1e-5**2, 1e-4**2, 1e-6**2, 1e-5**2)
"""Variances of y, dy, psi, dpsi at the start: the wheelset starts centred and at rest, but for these."""

FIRST_CREEP: Final = 1e-7
"""Creep at which the literal filter starts; at zero its equations are singular."""

CLASSES: Final[Mapping[Name, str]] = {
    "literal": "RailBraking.Predictions.LateralLiteral",
    "known_track": "RailBraking.Predictions.LateralPrediction",
    "unknown_track": "RailBraking.Predictions.LateralPredictionUnknownTrack",
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Observer:
    """A filter at its start.

    Attributes:
        name: Of the filter.
        filter: Its outputs are the readings.
        first: Belief at the start.
        columns: Column of the run's table for each input of the filter; "" for an integral.
        integrals: Input of the filter → state that it is the integral of.
    """

    name: Name
    filter: CompiledFilter
    first: Estimate
    columns: tuple[str, ...]
    integrals: Mapping[str, str] = field(default_factory=dict)


@cache
def prediction(name: Name, kind: Kind = "fmu") -> PredictionInC:
    """Return the model inside a filter, with the parameters of Table 1."""
    return prediction_of(CLASSES[name], kind=kind)


def literal_density(condition: Condition) -> Vector:
    """Return the process noise of the literal filter as a density, shape (5,)."""
    return np.array(LITERAL_NOISE[condition.name]) / PERIOD


def observer(
    name: Name,
    first: Condition,
    irregularity: Irregularity,
    sensors: tuple[float, float] = PAPER_SENSORS,
    kind: Kind = "fmu",
) -> Observer:
    """Return a filter at its start.

    Args:
        first: Condition at the start; only the literal filter is told.
        irregularity: Of the track; only the filter of unknown track uses it, for the spectrum.
        sensors: Standard deviations of the readings.
        kind: What it evaluates.
    """
    model = prediction(name, kind)
    noise = np.square(sensors)
    if name == "literal":
        filter_ = CompiledFilter(model, literal_density(first), noise, PERIOD, order=1)
        # The paper gives no covariance for the start; one step of its process noise, since all is known.
        start = filter_.start([0, 0, FIRST_CREEP, first.mu0, 0], LITERAL_NOISE[first.name])
        filter_.inputs[:] = 0.0
        integrals = {"lateral_position": "dy", "yaw_angle": "dpsi"}
        columns = tuple("" if input_ in integrals else input_ for input_ in filter_.design.inputs)
        return Observer(name=name, filter=filter_, first=start, columns=columns, integrals=integrals)
    density = [*MOTION_NOISE, FRICTION_NOISE]
    mean, variance = [0.0, 0.0, 0.0, 0.0, log(FIRST_FRICTION[0])], [*FIRST_MOTION, FIRST_FRICTION[1] ** 2]
    if name == "unknown_track":
        density += [0.0, irregularity.acceleration_density(TRACK_DEVIATION)]
        mean += [0.0, 0.0]
        variance += [1e-5**2, 1e-5**2]
    filter_ = CompiledFilter(model, density, noise, PERIOD)
    return Observer(name=name, filter=filter_, first=filter_.start(mean, variance), columns=filter_.design.inputs)
