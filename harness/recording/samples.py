"""Signals of a trace by the names of a model, such as `wheelset_speed[2]`, in the requested units."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np
import xarray
from numpy.typing import ArrayLike

from railgrip.base.arrays import Vector
from railgrip.base.errors import EstimationError, UnitError
from railgrip.base.names import ElementName, state_name
from railgrip.base.units import conversion, unit
from railgrip.vehicle import signals as tables

Signals = Mapping[str, tuple[ArrayLike, str]]
"""Name, with its index if it is an element, → samples and unit, in Modelica's syntax and SI."""

READING = "reading_"
"""Prefix of what a filter may see."""

_OFF_GRID = 1e-3
"""Share of a period by which samples may be off the grid: a microsecond a millisecond of clock error is normal, more
means a gap or another rate."""


def recording_of(
    readings: Signals, *, period: float, truth: Signals | None = None, start: float = 0.0, name: str = ""
) -> xarray.Dataset:
    """Return a trace of signals that were sampled together.

    Args:
        readings: What was measured, each shape (k,), NaN where there was nothing new.
        period: Between samples [s].
        truth: State or signal → true values, each shape (k,).
        start: Time of the first sample [s].
        name: Of the recording, for figures and sentences.

    Raises:
        EstimationError: Signals of different lengths, or an invalid period.
    """
    arrays = {key: np.asarray(values) for key, (values, _) in [*readings.items(), *(truth or {}).items()]}
    lengths = {values.shape for values in arrays.values()}
    if len(lengths) != 1 or len(next(iter(lengths))) != 1:
        shapes = ", ".join(f"{key} {values.shape}" for key, values in arrays.items())
        raise EstimationError(f"recording '{name}': each signal must have one sample per instant, got {shapes}.")
    if not (np.isfinite(period) and period > 0.0):
        raise EstimationError(f"recording '{name}': the period is a positive number of seconds, got {period}.")
    # Counted and multiplied, never summed.
    time = start + np.arange(next(iter(lengths))[0]) * period
    empty = xarray.Dataset(coords={"time": ("time", time, {"units": "s"})}, attrs={"name": name, "period": period})
    return with_signals(empty, readings, truth)


def with_signals(
    trace: xarray.Dataset, readings: Signals | None = None, truth: Signals | None = None
) -> xarray.Dataset:
    """Return a trace with more signals, in place of those of the same names; see `recording_of`."""
    columns: dict[str, dict[int | None, Vector]] = defaultdict(dict)
    units: dict[str, str] = {}
    for prefix, group in ((READING, readings or {}), ("", truth or {})):
        for key, (values, unit_text) in group.items():
            base, index = _element(key)
            variable = prefix + (base if prefix else state_name(base))
            columns[variable][index] = np.asarray(values, dtype=np.float64)
            units[variable] = unit_text
    dimensions = {variable: dimension_of(variable) for variable, parts in columns.items() if None not in parts}
    # A dimension whose size this signal does not show may have it from another signal.
    sizes = {str(dimension): size for dimension, size in trace.sizes.items()}
    for variable, dimension in dimensions.items():
        most = max(index for index in columns[variable] if index is not None)
        sizes[dimension] = max(most, sizes.get(dimension, 0))
    wider = {dimension: size for dimension, size in sizes.items() if size > trace.sizes.get(dimension, size)}
    if wider:
        trace = trace.reindex({dimension: np.arange(1, size + 1) for dimension, size in wider.items()})
    variables: dict[str, tuple[tuple[str, ...], Vector, dict[str, str]]] = {}
    for variable, parts in columns.items():
        about = {"units": units[variable]}
        if variable not in dimensions:
            variables[variable] = ("time",), parts[None], about
            continue
        block = np.full((trace.sizes["time"], sizes[dimensions[variable]]), np.nan)
        for index, values in parts.items():
            block[:, (index or 1) - 1] = values
        variables[variable] = ("time", dimensions[variable]), block, about
    coordinates = {dimension: np.arange(1, sizes[dimension] + 1) for dimension in dimensions.values()}
    return trace.drop_vars(variables, errors="ignore").assign_coords(coordinates).assign(variables)


def evenly(trace: xarray.Dataset, name: str = "") -> xarray.Dataset:
    """Return a trace without its last row if that is off the grid, as of a stop that was thinned, and with a name."""
    time = trace["time"].values
    if time.size > 2 and abs((time[-1] - time[-2]) - (time[1] - time[0])) > _OFF_GRID * (time[1] - time[0]):
        trace = trace.isel(time=slice(0, -1))
    return trace.assign_attrs(name=trace.attrs.get("name") or name, period=period_of(trace))


def period_of(trace: xarray.Dataset) -> float:
    """Return the time between samples [s].

    Raises:
        EstimationError: Fewer than two samples, or instants that are not evenly spaced.
    """
    time = trace["time"].values
    if time.size < 2:
        raise EstimationError(f"recording '{_name(trace)}': {time.size} samples; an estimate needs at least two.")
    steps = np.diff(time)
    period = float(trace.attrs.get("period") or _infer_period(time))
    worst = int(np.argmax(np.abs(steps - period)))
    if abs(steps[worst] - period) > _OFF_GRID * period:
        raise EstimationError(
            f"recording '{_name(trace)}': the grid is uneven, {steps[worst]:.6g} s after {time[worst]:.6g} s "
            f"where {period:.6g} s is the rule; resample it first."
        )
    return period


def _infer_period(time: Vector) -> float:
    """Return the period that instants were counted with, of which their differences have lost the last bits."""
    step = float(np.median(np.diff(time)))
    short = float(f"{step:.7g}")
    return short if abs(short - step) <= 4.0 * np.spacing(np.abs(time).max()) else step


def samples(trace: xarray.Dataset, names: Sequence[str], units: Sequence[str | None] | None = None) -> Vector:
    """Return readings side by side, shape (k, len(names)).

    Args:
        trace: Of a stop, or of a recorder.
        names: As a model calls its inputs and outputs.
        units: Required units; None for those of the trace.

    Raises:
        EstimationError: A reading is not there or measures something else; every missing one in one sentence.
    """
    missing = [name for name in names if not has_reading(trace, name)]
    if missing:
        there = ", ".join(readings_in(trace))
        raise EstimationError(
            f"recording '{_name(trace)}' has no signal {', '.join(missing)}; it has {there or 'none'}. "
            "Map a column to each."
        )
    block = np.empty((trace.sizes["time"], len(names)))
    for column, (name, target) in enumerate(zip(names, units or [None] * len(names), strict=True)):
        block[:, column] = _column(trace, READING, name)
        source = unit_of(trace, name)
        if target is not None and target != source:
            gain, shift = _conversion(trace, name, source, target)
            block[:, column] = gain * block[:, column] + shift
    return block


def reading_of(trace: xarray.Dataset, name: str) -> Vector:
    """Return one reading, shape (k,), in the unit that it has; see `samples`."""
    return samples(trace, [name])[:, 0]


def has_reading(trace: xarray.Dataset, name: str) -> bool:
    """Return whether a reading is in a trace."""
    return _column(trace, READING, name) is not None


def readings_in(trace: xarray.Dataset, base: str | None = None) -> list[str]:
    """Return the names of all readings, or of the elements of one."""
    names: list[str] = []
    for variable in map(str, trace.data_vars):
        name = variable.removeprefix(READING)
        if variable.startswith(READING) and base in (None, name):
            width = trace[variable].shape[1] if trace[variable].ndim > 1 else 0
            names += [f"{name}[{i + 1}]" for i in range(width)] or [name]
    return names


def unit_of(trace: xarray.Dataset, name: str) -> str:
    """Return the unit of a reading, empty where it is not given or the reading is not there."""
    variable = READING + _element(name)[0]
    return str(trace[variable].attrs.get("units", "")) if variable in trace else ""


def truth_of(trace: xarray.Dataset, state: str) -> Vector:
    """Return the true values of a state of a model or of a signal, shape (k,).

    Raises:
        EstimationError: The trace does not have them.
    """
    values = _truth(trace, state)
    if values is None:
        raise EstimationError(
            f"recording '{_name(trace)}' does not have the true {state}; only recordings that include it do."
        )
    return values


def knows(trace: xarray.Dataset, state: str) -> bool:
    """Return whether a trace holds the true values of a state."""
    return _truth(trace, state) is not None


def _truth(trace: xarray.Dataset, state: str) -> Vector | None:
    values = _column(trace, "", state_name(state))
    return None if values is None or np.isnan(values).all() else values


def _column(trace: xarray.Dataset, prefix: str, name: str) -> Vector | None:
    base, index = _element(name)
    if prefix + base not in trace:
        return None
    values = trace[prefix + base].values
    if values.ndim == 1:
        return values if index in (None, 1) else None
    if index is None:
        return values[:, 0] if values.shape[1] == 1 else None
    return values[:, index - 1] if 1 <= index <= values.shape[1] else None


def _conversion(trace: xarray.Dataset, name: str, source: str, target: str) -> tuple[float, float]:
    try:
        return conversion(unit(source), unit(target))
    except UnitError as problem:
        raise EstimationError(
            f"recording '{_name(trace)}': {name} is in '{source}', the prediction needs '{target}': {problem}"
        ) from problem


def dimension_of(variable: str) -> str:
    """Return the dimension of a variable: groups, wheelsets, or one of the variable alone."""
    name = variable.removeprefix(READING)
    extent = _extents().get(name, "")
    return extent if extent in ("group", "wheelset") else f"{name}_number"


def _element(name: str) -> tuple[str, int | None]:
    element = ElementName.of(name)
    return element.array, int(element.label) if element.label.isdecimal() else None


@cache
def _extents() -> dict[str, str]:
    return {
        signal.name.removeprefix(READING): signal.extent
        for signal in (*tables.READINGS, *tables.PLANT_INPUTS, *tables.PLANT)
    }


def _name(trace: xarray.Dataset) -> str:
    return str(trace.attrs.get("name", "")) or "unnamed"
