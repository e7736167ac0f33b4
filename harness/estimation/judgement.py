"""Errors of an estimate with respect to the known truth, and bounds of plausible signals and estimates.

Values outside the bounds suggest a wrong unit, sign or column. The bounds are wide, so that every train is inside.
Their keys are names of signals without index; units are SI.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.base.errors import EstimationError
from railgrip.base.names import ElementName, state_name
from railgrip.estimators.belief import Array, Vector
from railgrip.recording.samples import reading_of, truth_of, unit_of

NORMAL_95: Final = 1.96
"""Half of a 95 % interval of a normal distribution, in standard deviations."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """Errors of one state, estimate minus truth, in its unit.

    Attributes:
        samples: Number of samples judged.
        rmse: Root-mean-square error.
        constant: RMSE of the best constant, the mean of the truth; a useful filter is better.
        bias: Mean error.
        largest: Maximum magnitude of the error.
        nees: Mean of (error/sd)²: 1 for a consistent filter, more for an overconfident one.
        coverage: Share of samples within two standard deviations: 0.954 for a consistent filter.
        sd: Median of the filter's standard deviation.
    """

    samples: int
    rmse: float
    constant: float
    bias: float
    largest: float
    nees: float
    coverage: float
    sd: float


def rms(values: Array) -> float:
    """Return the root mean square of values of any shape."""
    return float(np.sqrt(np.mean(values**2)))


def error_figures(error: Array, deviation: Array) -> dict[str, float]:
    """Return `RMSE`, `bias`, `coverage` of the 95 % interval and `NEES` of errors and their claimed deviations."""
    return {
        "RMSE": rms(error),
        "bias": float(np.mean(error)),
        "coverage": float(np.mean(np.abs(error) <= NORMAL_95 * deviation)),
        "NEES": float(np.mean((error / deviation) ** 2)),
    }


def _of_state(estimates: xarray.Dataset, what: str, state: str) -> Vector:
    """Return a result of a state by its name or its symbol; older estimates have the symbols."""
    known = set(estimates["state"].values.tolist())
    return estimates[what].sel(state=state if state in known else state_name(state)).values


def errors(recording: xarray.Dataset, estimates: xarray.Dataset, state: str) -> Vector:
    """Return estimate minus truth at every sample, shape (k,).

    Raises:
        EstimationError: The recording lacks the true state.
    """
    return _of_state(estimates, "mean", state) - truth_of(recording, state)


def judge(
    recording: xarray.Dataset, estimates: xarray.Dataset, state: str, where: NDArray[np.bool_] | None = None
) -> Judgement:
    """Return the errors of an estimate with respect to the truth and to the filter's standard deviation.

    Args:
        estimates: Result of `estimate` for that recording.
        where: Mask of the samples to judge; None for all after the first.

    Raises:
        EstimationError: The recording lacks the true state, or no sample is left to judge.
    """
    error = errors(recording, estimates, state)
    sd = _of_state(estimates, "sd", state)
    mask = (np.arange(error.size) > 0) if where is None else where
    mask = mask & np.isfinite(error)
    if not mask.any():
        raise EstimationError(f"judge: no sample of {state} is left to judge.")
    e, s = error[mask], sd[mask]
    return Judgement(
        samples=int(mask.sum()),
        rmse=rms(e),
        constant=float(np.std(truth_of(recording, state)[mask])),
        bias=float(np.mean(e)),
        largest=float(np.max(np.abs(e))),
        nees=float(np.mean((e / s) ** 2)),
        coverage=float(np.mean(np.abs(e) <= 2.0 * s)),
        sd=float(np.median(s)),
    )


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
