"""Estimators of users in the study: a class in Python, or a prediction FMU in the extended Kalman filter."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
import xarray

from railgrip.base.errors import InputError
from railgrip.controllers.observation import Observation
from railgrip.estimation.sources import stop_read
from railgrip.estimators.belief import Array, Vector
from railgrip.scenario.table import Custom
from railgrip.simulate.user_parts import CustomParts, Estimate, Estimator, part_of
from railgrip.studies.estimators.recordings import RecordingCase, recording_of_case, scenario_of_case
from railgrip.vehicle.formation import Formation

_SPEEDS: Final = ("speed", "wheelset_speed", "slip")
"""Estimates that a controller uses in place of readings."""


def is_class(estimator: str) -> bool:
    """Return whether an argument of `--estimator` is FILE.py:CLASS."""
    return ":" in estimator


def is_fmu(estimator: str) -> bool:
    """Return whether an argument of `--estimator` is the prediction FMU of a user."""
    return Path(estimator).suffix == ".fmu"


def name_of(estimator: str) -> str:
    """Return the name of an estimator in tables: its class, the name of its FMU, or the name itself."""
    return Path(estimator).stem if is_fmu(estimator) else estimator.rpartition(":")[2]


def require_file(estimator: str) -> None:
    """Raise `InputError` unless the file of a user's estimator exists and has a suffix of its kind."""
    file = Path(estimator.rpartition(":")[0] or estimator)
    if is_class(estimator) and file.suffix != ".py":
        raise InputError(f"--estimator {estimator}: expected FILE.py:CLASS, the file of a class in Python.")
    if not file.is_file():
        raise InputError(f"--estimator {estimator}: there is no file {file}.")


def require_one_of_each_name(estimators: Iterable[str]) -> None:
    """Check that tables can distinguish the estimators, and that Python can import their modules.

    Raises:
        InputError: Two have one name, or two files that are imported have one.
    """
    of_name, of_module = dict[str, str](), dict[str, tuple[str, Path]]()
    for estimator in dict.fromkeys(estimators):
        earlier = of_name.setdefault(name_of(estimator), estimator)
        if earlier != estimator:
            raise InputError(
                f"--estimator {estimator}: would have the name of {earlier} in the tables, {name_of(estimator)}; "
                "rename one."
            )
        if is_class(estimator):
            file = Path(estimator.rpartition(":")[0]).resolve()
            other, path = of_module.setdefault(file.stem, (estimator, file))
            if path != file:
                raise InputError(
                    f"--estimator {estimator}: {file.name} is another file than that of {other}, and Python imports "
                    f"one module named '{file.stem}'; rename one of the files."
                )


def trace_with_class(case: RecordingCase, estimator: str) -> xarray.Dataset:
    """Return the recording of a case with the estimates of a user's class, which runs in the loop of the stop.

    Its speeds do not reach the controller, so that the readings are those of all other estimators.

    Raises:
        ScenarioError: The class cannot be imported, or the estimator fails.
    """
    file = Path(estimator.rpartition(":")[0]).resolve()
    own = _WithoutSpeeds(part_of(Custom(kind=f"{file.stem}:{name_of(estimator)}"), "estimators", (file.parent,)))
    recording = stop_read(scenario_of_case(case), case.stop.name, objects=CustomParts(estimator=own))
    for name, values in own.kept.items():
        if values:
            held = _held(np.array(list(values)), np.array(list(values.values())), recording["time"].values)
            recording[f"estimate_{name}"] = (("time", "group")[: held.ndim], held)
    return recording.assign(peak_adhesion=recording_of_case(case)["peak_adhesion"])


class _WithoutSpeeds:
    """A user's estimator whose speeds are not given to the controller.

    Attributes:
        kept: Speed [m/s] and slip that it has estimated, by time [s].
    """

    def __init__(self, estimator: Estimator) -> None:
        self._estimator = estimator
        self.kept: dict[str, dict[float, Array]] = {"speed": {}, "slip": {}}
        self.provides = tuple(name for name in estimator.provides if name not in _SPEEDS)

    def start(self, first: Observation, formation: Formation) -> None:
        self._estimator.start(first, formation)

    def step(self, observation: Observation) -> Estimate:
        estimate = self._estimator.step(observation)
        for name, values in self.kept.items():
            if (value := getattr(estimate, name)) is not None:
                values[observation.time] = np.array(value, dtype=np.float64)
        return replace(estimate, **dict.fromkeys(_SPEEDS))


def _held(time: Vector, values: Array, at: Vector) -> Array:
    """Return the last of the values at other times, the first one before it."""
    return values[np.maximum(np.searchsorted(time, at + 1e-9, side="right") - 1, 0)]
