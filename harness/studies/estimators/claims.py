"""Deviations by errors that are in no equation of the predictions: load, inertia, radar scale, pressure transducers."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray

from railgrip.base.names import ElementName
from railgrip.estimation.models import PredictionModel
from railgrip.estimators.belief import Matrix, Vector
from railgrip.estimators.tuning import NOISE_SETS
from railgrip.fmus.native import Model
from railgrip.simulate.estimator import RELEASED_PADS
from railgrip.simulate.train_prediction import release_pressure
from railgrip.studies.estimators.recordings import PERIOD, Sensors

LOAD_DEVIATION: Final = NOISE_SETS["loaded_service"].start["payload"]
"""Relative standard deviation of the load, from empty to laden: adhesion is a force over a load that is not read."""

INERTIA_DEVIATION: Final = 0.1 / math.sqrt(3.0)
"""Relative standard deviation of the inertia of the wheelsets, even within 10 %: wheels wear by some 10 % of it."""

RATE_TIME: Final = 0.1
"""Time over which the acceleration of the wheelsets is taken [s]; noise of their speeds gives it a few rad/s²."""


def force_over_load_deviation() -> float:
    """Return √E(1/ℓ − 1)², the relative deviation of a known force over a load ℓ that is even within 1 ± √3 σ_load.

    It exceeds σ_load, as a load of 1 − h changes the ratio more than one of 1 + h.
    """
    half = math.sqrt(3.0) * LOAD_DEVIATION
    mean, square = math.log((1.0 + half) / (1.0 - half)) / (2.0 * half), 1.0 / (1.0 - half**2)
    return math.sqrt(square - 2.0 * mean + 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class UnmodelledErrors:
    """Standard deviations of constant errors of a class of sensors, as in equipment/service.toml.

    Attributes:
        speed_scale: Relative error of the radar [1].
        pressure: Offset of a pressure transducer [Pa].
    """

    speed_scale: float
    pressure: float


UNMODELLED: Final[Mapping[Sensors, UnmodelledErrors]] = {
    "ideal": UnmodelledErrors(speed_scale=0.0, pressure=0.0),
    "service": UnmodelledErrors(speed_scale=0.003, pressure=5e3),
    "worn": UnmodelledErrors(speed_scale=0.006, pressure=1e4),
}


def with_unmodelled(
    recording: xarray.Dataset,
    states: Sequence[str],
    mean: Matrix,
    variance: Matrix,
    sensors: Sensors,
    model: Model | PredictionModel,
    effect: Vector,
) -> Matrix:
    """Return the variances of an estimator plus those of the errors in no equation, shape (k, n).

    Adhesion α is (τ + J dω/dt)/(r N). It has α² E(1/ℓ − 1)² by the load ℓ, unless that is a state, and
    (σ_J/g dω/dt)² by the inertia J, g = r N/J. Pad friction μ has (μ σ_p/(p − p₀))², with the pressure p₀
    of the return spring, as the torque determines μ (p − p₀). Speed v has (v σ_scale)². All are independent of the
    errors of the estimator, and of first order but for the load.

    Args:
        recording: Samples of the estimates, at `PERIOD`.
        states: Names of the states.
        mean, variance: Estimates, shape (k, n).
        sensors: Class of sensors.
        model: Prediction with the parameters of the pads.
        effect: g = ∂(dω/dt)/∂α of each group [rad/s²], shape (groups,).
    """
    bases = [ElementName.of(name).array for name in states]
    of = {
        base: [k for k, name in enumerate(bases) if name == base]
        for base in ("speed", "wheelset_speed", "group_adhesion", "pad_friction")
    }
    errors, values = UNMODELLED[sensors], {variable.name: variable.start for variable in model.parameters}
    threshold, spring = (
        np.array([release_pressure(values, group, force) for group in range(len(of["pad_friction"]))])
        for force in (RELEASED_PADS, 0.0)
    )
    pressure = np.nan_to_num(recording["reading_cylinder_pressure"].values)
    offset = errors.pressure / (np.maximum(pressure, threshold) - spring)
    total = variance.copy()
    total[:, of["speed"]] += (mean[:, of["speed"]] * errors.speed_scale) ** 2
    if "payload" not in states:
        total[:, of["group_adhesion"]] += (mean[:, of["group_adhesion"]] * force_over_load_deviation()) ** 2
    total[:, of["group_adhesion"]] += (INERTIA_DEVIATION * _rate(mean[:, of["wheelset_speed"]]) / effect) ** 2
    total[:, of["pad_friction"]] += (mean[:, of["pad_friction"]] * offset) ** 2
    return total


def _rate(speeds: Matrix) -> Matrix:
    """Return the mean derivative of the last `RATE_TIME`, 0 before it, shape (k, groups)."""
    steps = round(RATE_TIME / PERIOD)
    rate = np.zeros_like(speeds)
    rate[steps:] = (speeds[steps:] - speeds[:-steps]) / RATE_TIME
    return rate
