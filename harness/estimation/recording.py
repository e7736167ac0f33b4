"""A recording: signals on one even time grid, by the names of a prediction's inputs and outputs, with units.

The only dimension is `time` [s]. Variables are scalars; an element of an array is `name[i]`, as in FMI. A sample
that is NaN says that the sensor had nothing new then. `true_<state>` is what a twin knows about a state.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray
from numpy.typing import ArrayLike, NDArray

from railgrip.errors import EstimationError

Vector = NDArray[np.float64]
Signals = Mapping[str, tuple[ArrayLike, str]]
"""Name → samples and unit, in Modelica's syntax and SI."""

TRUTH = "true_"
"""Prefix of the variables that no filter may see."""


def recording_of(
    signals: Signals, *, period: float, truth: Signals | None = None, start: float = 0.0, name: str = ""
) -> xarray.Dataset:
    """Return a recording of signals that were sampled together.

    Args:
        signals: What was measured, each shape (k,).
        period: Between samples [s].
        truth: By state, what they really were, each shape (k,).
        start: Time of the first sample [s].
        name: Of the recording, for figures and sentences.

    Raises:
        EstimationError: Signals of different lengths, or a period that is none.
    """
    everything = {**signals, **{TRUTH + state: told for state, told in (truth or {}).items()}}
    arrays = {key: (np.asarray(values, dtype=np.float64), unit) for key, (values, unit) in everything.items()}
    lengths = {values.shape for values, _ in arrays.values()}
    if len(lengths) != 1 or len(next(iter(lengths))) != 1:
        found = ", ".join(f"{key} {values.shape}" for key, (values, _) in arrays.items())
        raise EstimationError(f"recording '{name}': signals want one sample at every instant each, got {found}.")
    if not (np.isfinite(period) and period > 0.0):
        raise EstimationError(f"recording '{name}': the period is a positive number of seconds, got {period}.")
    count = next(iter(lengths))[0]
    return xarray.Dataset(
        {key: (("time",), values, {"units": unit}) for key, (values, unit) in arrays.items()},
        # Counted and multiplied, never summed.
        coords={"time": ("time", start + np.arange(count) * period, {"units": "s"})},
        attrs={"name": name, "period": float(period)},
    )


def period_of(recording: xarray.Dataset) -> float:
    """Return the time between samples [s].

    Raises:
        EstimationError: Fewer than two samples, or instants that are not evenly spaced.
    """
    time = recording["time"].values
    if time.size < 2:
        raise EstimationError(f"recording '{_name(recording)}': {time.size} samples; an estimate wants two at least.")
    steps = np.diff(time)
    period = float(recording.attrs.get("period", np.median(steps)))
    # A microsecond a second of clock error is normal; more means a gap or another rate.
    worst = int(np.argmax(np.abs(steps - period)))
    if abs(steps[worst] - period) > 1e-3 * period:
        raise EstimationError(
            f"recording '{_name(recording)}': the grid is uneven, {steps[worst]:.6g} s after {time[worst]:.6g} s "
            f"where {period:.6g} s is the rule; resample it first."
        )
    return period


def columns(recording: xarray.Dataset, names: Sequence[str], units: Sequence[str]) -> NDArray[np.float64]:
    """Return the samples of `names` side by side, shape (k, len(names)).

    Raises:
        EstimationError: A name is not there or has another unit; every problem in one sentence.
    """
    missing = [wanted for wanted in names if wanted not in recording]
    if missing:
        there = ", ".join(str(key) for key in recording.data_vars if not str(key).startswith(TRUTH))
        raise EstimationError(
            f"recording '{_name(recording)}' has no signal {', '.join(missing)}; it has {there or 'none'}. "
            "Map a column to each."
        )
    for wanted, unit in zip(names, units, strict=True):
        found = recording[wanted].attrs.get("units")
        if found != unit:
            raise EstimationError(
                f"recording '{_name(recording)}': {wanted} is in '{found}', the prediction wants '{unit}'; convert it."
            )
    if not names:
        return np.empty((recording.sizes["time"], 0))
    return np.stack([recording[wanted].values for wanted in names], axis=1)


def truth_of(recording: xarray.Dataset, state: str) -> Vector:
    """Return what a state really was, shape (k,).

    Raises:
        EstimationError: The recording does not tell.
    """
    if TRUTH + state not in recording:
        raise EstimationError(
            f"recording '{_name(recording)}' does not know the true {state}; only twins do, and those that they tell."
        )
    return recording[TRUTH + state].values


def _name(recording: xarray.Dataset) -> str:
    return str(recording.attrs.get("name", "")) or "unnamed"
