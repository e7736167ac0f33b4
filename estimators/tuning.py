"""Named noises for the prediction models of the train, which `noises.toml` gives with their reasons."""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files

import numpy as np

from railgrip.errors import EstimatorError
from railgrip.estimators.belief import Vector
from railgrip.estimators.design import Gate


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseSet:
    """Everything a filter over a prediction is told about noise: standard deviations by name, without index.

    Attributes:
        name: For reports.
        process: Of the states, in their unit per √s.
        readings: Of the outputs, in their unit.
        start: Of the states at the start, in their unit.
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
        """Return the squared deviation of each name, by what stands before its index."""
        missing = sorted({name.partition("[")[0] for name in names} - deviations.keys())
        if missing:
            raise EstimatorError(
                f"Noise set '{self.name}': no {what} for {', '.join(missing)}; it has {', '.join(deviations)}."
            )
        return np.array([deviations[name.partition("[")[0]] for name in names]) ** 2


def _noise_sets() -> dict[str, NoiseSet]:
    tables = tomllib.loads((files("railgrip.estimators") / "noises.toml").read_text(encoding="utf-8"))

    def together(of: str, names: Sequence[str]) -> dict[str, float]:
        return {variable: value for name in names for variable, value in tables[of][name].items()}

    return {
        key: NoiseSet(name=entry["name"], **{of: together(of, entry[of]) for of in ("process", "readings", "start")})
        for key, entry in tables["sets"].items()
    }


NOISE_SETS = _noise_sets()
"""The sets by the names that scenario files use."""


def pad_gate(
    *, pad_force: float, A_piston: float, i_rigging: float, eta_rigging: float, F_spring: float, groups: int
) -> Gate:
    """Return the gate that holds the pad friction of a group still while its pads are released.

    Args:
        pad_force: Normal force of both pads of one unit in N below which they count as released; 1–2 kN
            of the 56 kN at full brake: the torque of the pads is then within the errors of the other torques.
        A_piston: Area of a piston, m².
        i_rigging: Force of both pads over force of the piston.
        eta_rigging: Efficiency of the rigging.
        F_spring: Force of return spring and slack adjuster, N.
        groups: Number of brake groups.
    """
    return Gate(
        states=tuple(f"mu_b[{i}]" for i in range(1, groups + 1)),
        inputs=tuple(f"cylinder_pressure[{i}]" for i in range(1, groups + 1)),
        threshold=(pad_force / (eta_rigging * i_rigging) + F_spring) / A_piston,
    )


def pressure_spread(
    *, pad_friction: Vector, pressure: Vector, offset: float, A_piston: float, F_spring: float
) -> Vector:
    """Return the 1σ error that a pressure transducer's offset adds to an estimated pad friction, in its shape.

    The filter cannot know it (see train_service in noises.toml); whoever compares pad friction with a law, as the brake
    monitor does, adds it to the filter's own deviation, root of the sum of squares. It is the same error in every stop.

    Args:
        pad_friction: Estimated.
        pressure: In the cylinder, Pa; infinite results where it does not press the pads.
        offset: 1σ of the transducer's offset, Pa.
        A_piston: Area of a piston, m².
        F_spring: Force of return spring and slack adjuster, N.
    """
    pressing = np.maximum(np.asarray(pressure) * A_piston - F_spring, 0.0)
    with np.errstate(divide="ignore"):
        return np.asarray(pad_friction) * offset * A_piston / pressing
