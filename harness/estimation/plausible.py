"""Bounds of plausible signals and estimates; values outside suggest a wrong unit, sign or column.

The bounds are wide, so that every train is inside. Their keys are names of signals without index; units are SI.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.base.names import ElementName
from railgrip.estimators.belief import Vector
from railgrip.recording.samples import reading_of, unit_of


@dataclass(frozen=True, slots=True)
class Bounds:
    """Minimum and maximum of a quantity, with the reason."""

    low: float
    high: float
    reason: str


_SPEED: Final = Bounds(-5.0, 170.0, "trains have reached 160 m/s")
_ROTATION: Final = Bounds(-20.0, 500.0, "160 m/s on wheels of 0.32 m")
_FRICTION: Final = Bounds(0.0, 1.0, "brake pads reach 0.5")
_ADHESION: Final = Bounds(-1.0, 1.0, "dry rails reach 0.6")

SIGNALS: Final[Mapping[str, Bounds]] = {
    "speed": _SPEED,
    "wheelset_speed": _ROTATION,
    "acceleration": Bounds(-30.0, 30.0, "an emergency brake reaches 3 m/s2, a hard coupling 20"),
    "deflection": Bounds(-0.2, 0.2, "primary suspensions give way by 0.05 m"),
    "cylinder_pressure": Bounds(-2e4, 1.2e6, "brakes are supplied with 10 bar"),
    "pad_force": Bounds(
        -2e3, 5e5, "pads press, they do not pull; with a spring write minimum = '0 N' in [data.columns]"
    ),
    "track_force": Bounds(-5e6, 5e6, "a train of 5000 t on a slope of 10 %"),
    "wheel_torque": Bounds(-2e5, 2e5, "a locomotive's axle reaches 60 kN.m"),
}
"""Inputs and readings of the prediction models."""

STATES: Final[Mapping[str, Bounds]] = {
    "speed": _SPEED, "wheelset_speed": _ROTATION, "pad_friction": _FRICTION, "group_adhesion": _ADHESION,
}  # fmt: skip
"""States of the prediction models."""

TOLERATED: Final = 0.01
"""Share of samples outside the bounds that outliers of a sensor may explain."""


def check_signals(recording: xarray.Dataset, names: Iterable[str]) -> list[str]:
    """Return a sentence for each signal that is outside its bounds in more than `TOLERATED` of its samples."""
    sentences: list[str] = []
    for name in names:
        bounds, values = SIGNALS.get(_family(name)), reading_of(recording, name)
        if bounds is not None:
            beyond = ~((values >= bounds.low) & (values <= bounds.high)) & ~np.isnan(values)
            unit = unit_of(recording, name)
            sentences += _sentences(
                f"{name} is", "wrong unit, sign or column?", values, beyond, recording, bounds, unit
            )
    return sentences


def check_estimates(estimates: xarray.Dataset) -> list[str]:
    """Return a sentence for each state that is outside its bounds by 2σ in more than `TOLERATED` of its samples."""
    sentences: list[str] = []
    for state in map(str, estimates["state"].values):
        bounds = STATES.get(_family(state))
        if bounds is not None:
            mean, sd = (estimates[what].sel(state=state).values for what in ("mean", "sd"))
            beyond = (mean + 2.0 * sd < bounds.low) | (mean - 2.0 * sd > bounds.high)
            what = f"the filter assumes {state} of"
            sentences += _sentences(what, "readings and model do not fit.", mean, beyond, estimates, bounds, "")
    return sentences


def _sentences(
    what: str, question: str, values: Vector, beyond: NDArray[np.bool_], of: xarray.Dataset, bounds: Bounds, unit: str
) -> Sequence[str]:
    if np.mean(beyond) <= TOLERATED:
        return ()
    worst = int(np.argmax(np.where(beyond, np.abs(values), -1.0)))
    unit = f" {unit}" if unit not in ("", "1") else ""
    return (
        f"{what} {values[worst]:.4g}{unit} at {of['time'].values[worst]:.3f} s and beyond {bounds.low:g} to "
        f"{bounds.high:g}{unit} in {100 * np.mean(beyond):.0f} % of its samples ({bounds.reason}); {question}",
    )


def _family(name: str) -> str:
    return ElementName.of(name).array
