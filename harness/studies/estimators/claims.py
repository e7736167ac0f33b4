"""Deviations by errors that are in no equation of the predictions: load, scale of the radar, pressure transducers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray

from railgrip.estimation.models import PredictionModel
from railgrip.estimators.belief import Matrix
from railgrip.estimators.tuning import NOISE_SETS
from railgrip.fmus.native import Model
from railgrip.simulate.estimator import RELEASED_PADS
from railgrip.simulate.prediction import release_pressure
from railgrip.studies.estimators.recordings import Sensors

LOAD_DEVIATION: Final = NOISE_SETS["loaded_service"].start["payload"]
"""Relative standard deviation of the load, from empty to laden: adhesion is a force over a load that is not read."""


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
) -> Matrix:
    """Return the variances of an estimator plus those of the errors in no equation, shape (k, n).

    Adhesion α has (α σ_load)², unless the load is a state. Pad friction μ has (μ σ_p/(p − p₀))², with the pressure p₀
    of the return spring, as the torque determines μ (p − p₀). Speed v has (v σ_scale)². All are of first order, and
    independent of the errors of the estimator.
    """
    bases = [name.partition("[")[0] for name in states]
    of = {base: [k for k, name in enumerate(bases) if name == base] for base in ("v", "alpha", "mu_b")}
    errors, values = UNMODELLED[sensors], {variable.name: variable.start for variable in model.parameters}
    threshold, spring = (
        np.array([release_pressure(values, group, force) for group in range(len(of["mu_b"]))])
        for force in (RELEASED_PADS, 0.0)
    )
    pressure = np.nan_to_num(recording["reading_cylinder_pressure"].values)
    offset = errors.pressure / (np.maximum(pressure, threshold) - spring)
    total = variance.copy()
    total[:, of["v"]] += (mean[:, of["v"]] * errors.speed_scale) ** 2
    if "payload" not in states:
        total[:, of["alpha"]] += (mean[:, of["alpha"]] * LOAD_DEVIATION) ** 2
    total[:, of["mu_b"]] += (mean[:, of["mu_b"]] * offset) ** 2
    return total
