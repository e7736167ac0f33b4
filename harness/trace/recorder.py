"""Rows of a stop while it runs, one preallocated block written in place by the loop, and the trace that they become."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.base.errors import RecordError
from railgrip.vehicle.formation import Formation, formation_of
from railgrip.vehicle.signals import (
    DEMANDED,
    DRIVEN,
    ESTIMATES,
    EXTRA,
    PLANT,
    READINGS,
    SENT,
    Signal,
    length,
    places,
)

_GROUPS = "group_of_wheelset"

_STANDARD_NAMES = {"speed": {"standard_name": "platform_speed_wrt_ground"}}
"""Signals that the CF convention has a standard name for; its table knows nothing else of trains."""


class Recorder:
    """Preallocated rows, and the columns of each signal.

    The loop keeps `rows` and the columns it needs as locals and writes `rows[k, columns["slip"]] = slip`, or adjacent
    signals at once in their `block`; a signal of the train may also be written by its number,
    `rows[k, at["speed"]] = speed`.

    Attributes:
        rows: Shape (capacity, width). Memory is taken as they are written; other rows are undefined. The last row is
            overwritten by every sample beyond the capacity.
        written: Number of rows that the loop filled, from the first on.
        columns: Signal name → columns of a row.
        at: Signal name → first column.
    """

    __slots__ = ("_formation", "_signals", "at", "columns", "rows", "written")

    def __init__(self, signals: Iterable[Signal], formation: Formation, capacity: int) -> None:
        """Make room for `capacity` samples of the signals of a vehicle, in their order."""
        self._signals, self._formation = tuple(signals), formation
        self.columns = places(self._signals, formation)
        self.at = MappingProxyType({name: columns.start for name, columns in self.columns.items()})
        # Not filled with NaN: a stop of half a minute leaves most of its horizon unused, some 50 MB.
        self.rows = np.empty((capacity, length(self.columns)))
        self.written = 0

    def block(self, signals: Sequence[Signal]) -> slice:
        """Return the columns of adjacent signals in the rows, in their order."""
        return slice(self.columns[signals[0].name].start, self.columns[signals[-1].name].stop)

    def trace(self, count: int, period: float) -> xarray.Dataset:
        """Return the first `count` rows, or all, sampled every `period` [s] from the brake demand on, as a trace.

        The arrays are views: the recorder must not be written to afterwards.
        """
        blocks = {
            signal: self.rows[: min(count, len(self.rows)), self.columns[signal.name]] for signal in self._signals
        }
        return trace_of(blocks, self._formation, period)


def trace_of(blocks: Mapping[Signal, NDArray[np.float64]], formation: Formation, period: float) -> xarray.Dataset:
    """Return a trace of signals sampled together.

    Args:
        blocks: Signal → its samples, shape (n, width); the arrays are kept, not copied.
        formation: Of the vehicle.
        period: Of the samples [s]; the first is the brake demand.
    """
    count = len(next(iter(blocks.values())))
    variables = {
        signal.name: (
            ("time",) if signal.extent == "train" else ("time", signal.extent),
            block.reshape(count) if signal.extent == "train" else block,
            {"units": signal.unit, "long_name": signal.meaning, **_STANDARD_NAMES.get(signal.name, {})},
        )
        for signal, block in blocks.items()
    }
    couplers = next((block.shape[1] for signal, block in blocks.items() if signal.extent == "coupler"), 0)
    numbers = {
        "group": (formation.groups, "group of wheelsets that turn as one"),
        "wheelset": (formation.wheelsets, "wheelset, lead to trail"),
    } | ({"coupler": (couplers, "coupler, lead to trail")} if couplers else {})
    of_wheelsets: dict[str, tuple[NDArray[Any], dict[str, str]]] = {
        _GROUPS: (1 + formation.group_of_wheelset, {"long_name": "group that the wheelset turns with"})
    }
    if formation.position is not None:
        behind = {"units": "m", "long_name": "distance of the wheelset behind the leading one"}
        of_wheelsets["wheelset_position"] = formation.position, behind
    if formation.wheelsets_per_car:
        cars = np.repeat(1 + np.arange(formation.cars), formation.wheelsets_per_car)
        of_wheelsets["car_of_wheelset"] = cars, {"long_name": "car that the wheelset carries"}
    # Time is counted and multiplied, never summed.
    time = np.arange(count) * period, {"units": "s", "long_name": "time since the brake demand"}
    return xarray.Dataset(
        variables | {name: (("wheelset",), values, text) for name, (values, text) in of_wheelsets.items()},
        coords={"time": ("time", *time)}
        | {name: (name, np.arange(1, number + 1), {"long_name": text}) for name, (number, text) in numbers.items()},
    )


_REQUIRED = ("speed", "distance", "mu0", "adhesion", _GROUPS)
_DIMENSIONS = {
    **{
        signal.name: ("time",) if signal.extent == "train" else ("time", signal.extent)
        for signal in (*PLANT, *EXTRA, *SENT, *DEMANDED, *DRIVEN, *READINGS, *ESTIMATES)
    },
    **dict.fromkeys(("peak_adhesion", "peak_slip"), ("time", "group")),
    **dict.fromkeys((_GROUPS, "wheelset_position", "car_of_wheelset"), ("wheelset",)),
}
"""Variable of a stop's trace → its dimensions."""


def formation_in(trace: xarray.Dataset) -> Formation:
    """Return the formation of the vehicle that a trace is of."""
    return formation_of(trace[_GROUPS].values.tolist())


def require_stop(path: Path, trace: xarray.Dataset, *, groups: int) -> None:
    """Check that a trace from a file has the signals of a stop, each with the dimensions of its extent.

    Args:
        path: Of the file, for the message.
        groups: Number of groups in the figures of the stop.

    Raises:
        RecordError: A signal is missing or has other dimensions, or the formation is not one.
    """
    problems = [f"'{name}' is missing" for name in _REQUIRED if name not in trace]
    for name, variable in trace.variables.items():  # a signal that is its only dimension is a coordinate
        expected = _DIMENSIONS.get(str(name), variable.dims)
        if variable.dims != expected:
            problems.append(f"'{name}' has the dimensions {variable.dims}, {expected} are expected")
        if "time" not in variable.dims and not np.isfinite(variable.values).all():
            problems.append(f"'{name}' has values that are not finite")
        mean = str(name).removesuffix("_sd")
        if mean not in trace:
            problems.append(f"'{name}' is a standard deviation of '{mean}', which is missing")
    if not problems:
        try:
            found = formation_in(trace).groups
        except (ValueError, IndexError, OverflowError) as problem:
            problems.append(str(problem))
        else:
            if not found == trace.sizes["group"] == groups:
                problems.append(f"it has {found} groups of wheelsets, {groups} are expected")
    if problems:
        raise RecordError(f"{path}: is not the trace of a stop: {'; '.join(problems[:3])}")


def thin(trace: xarray.Dataset, every: int) -> xarray.Dataset:
    """Return every n-th sample and the last one."""
    count = trace.sizes["time"]
    indices = np.unique(np.append(np.arange(0, count, every), count - 1))
    return trace.isel(time=indices)
