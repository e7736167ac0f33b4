"""Named sets of noises for the prediction models of the train; `noises.toml` has them with their reasons."""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files

import numpy as np

from railgrip.base.errors import EstimatorError
from railgrip.base.names import ElementName
from railgrip.estimators.belief import Vector
from railgrip.estimators.design import Gate


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseSet:
    """Noises that a filter assumes: standard deviations by variable, without index.

    Attributes:
        name: Name in reports.
        process: Process noise of the states, in their unit per √s.
        readings: Noise of the readings, in their unit.
        start: Standard deviation of the states at the start, in their unit.
    """

    name: str
    process: Mapping[str, float]
    readings: Mapping[str, float]
    start: Mapping[str, float]

    def process_noise(self, states: Sequence[str]) -> Vector:
        """Return the densities of independent process noises in (unit of the state)²/s, shape (n,)."""
        return self._squares("process noise", self.process, states)

    def reading_noise(self, outputs: Sequence[str]) -> Vector:
        """Return the variances of independent readings, shape (m,)."""
        return self._squares("reading noise", self.readings, outputs)

    def start_covariance(self, states: Sequence[str]) -> Vector:
        """Return the variances of the states at the start, shape (n,)."""
        return self._squares("start", self.start, states)

    def _squares(self, what: str, deviations: Mapping[str, float], names: Sequence[str]) -> Vector:
        missing = sorted({ElementName.of(name).array for name in names} - deviations.keys())
        if missing:
            raise EstimatorError(
                f"Noise set '{self.name}': no {what} for {', '.join(missing)}; it has {', '.join(deviations)}."
            )
        return np.array([deviations[ElementName.of(name).array] for name in names]) ** 2


def _noise_sets() -> dict[str, NoiseSet]:
    tables = tomllib.loads((files("railgrip.estimators") / "noises.toml").read_text(encoding="utf-8"))

    def together(of: str, names: Sequence[str]) -> dict[str, float]:
        return {variable: value for name in names for variable, value in tables[of][name].items()}

    return {
        key: NoiseSet(name=entry["name"], **{of: together(of, entry[of]) for of in ("process", "readings", "start")})
        for key, entry in tables["sets"].items()
    }


NOISE_SETS = _noise_sets()
"""Sets of noises by their names in scenario files."""


def pad_gate(threshold: float, groups: int) -> Gate:
    """Return the gate that freezes the pad friction of each group while its pads are released.

    Args:
        threshold: Cylinder pressure below which pads count as released [Pa]. Where both pads press with 1 to 2 kN, of
            56 kN at full brake, their torque is within the errors of the other torques.
        groups: Number of brake groups.
    """
    return Gate(
        states=tuple(f"pad_friction[{i}]" for i in range(1, groups + 1)),
        inputs=tuple(f"cylinder_pressure[{i}]" for i in range(1, groups + 1)),
        threshold=threshold,
    )
