"""Rows of a stop while it runs, the trace that they become, and its NetCDF file.

The loop writes the rows in place, into one preallocated block. NetCDF is the only format of traces that is written.
"""

from collections.abc import Iterable, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from types import MappingProxyType
from typing import Any

import h5py
import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.base.errors import RecordError
from railgrip.base.files import write_bytes
from railgrip.base.records import LARGEST_TRACE, read_bounded
from railgrip.vehicle.formation import Formation, formation_of
from railgrip.vehicle.signals import (
    CONTROLLER_DEMAND,
    DRIVER_DEMAND,
    ESTIMATES,
    EXTRA,
    PLANT,
    PLANT_INPUTS,
    READINGS,
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
    numbers = {
        "group": (formation.groups, "group of wheelsets that turn as one"),
        "wheelset": (formation.wheelsets, "wheelset, lead to trail"),
    }
    numbers |= {
        signal.extent: (block.shape[1], f"{signal.extent}, lead to trail")
        for signal, block in blocks.items()
        if signal.extent in ("car", "coupler") and block.shape[1]
    }
    of_wheelsets: dict[str, tuple[NDArray[Any], dict[str, str]]] = {
        _GROUPS: (1 + formation.group_of_wheelset, {"long_name": "group that the wheelset turns with"})
    }
    if formation.position is not None:
        behind = {"units": "m", "long_name": "distance of the wheelset behind the leading one"}
        of_wheelsets["wheelset_position"] = formation.position, behind
    if formation.wheelsets_per_car:
        of_wheelsets["car_of_wheelset"] = 1 + formation.car_of_wheelset, {"long_name": "car that the wheelset carries"}
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
        for signal in (*PLANT, *EXTRA, *PLANT_INPUTS, *CONTROLLER_DEMAND, *DRIVER_DEMAND, *READINGS, *ESTIMATES)
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


FILE_NAME = "trace.nc"

CONVENTIONS = "CF-1.11"
"""Of the metadata: every variable has `long_name`, and `units` that UDUNITS reads where it has a unit."""

_ATTRIBUTES = ("units", "long_name", "standard_name")
_OF_ALL = ("name", "period")
"""Attributes of a recording; a stop does not have them."""


def write_trace(trace: xarray.Dataset, path: Path, about: Mapping[str, str | int] = MappingProxyType({})) -> None:
    """Write a trace as NetCDF 4 with attributes `about` the whole file; the same trace gives the same bytes.

    Written through h5py: xarray would add fill values and attributes that depend on its version, and h5netcdf takes
    longer for the metadata of forty signals than h5py for the samples. Samples lie there as they are: compressed they
    would take a quarter less room, and more than twice the time to write.
    """
    # HDF5 answers a full disk by a crash; a file that is made in memory is written by Python.
    with h5py.File(FILE_NAME, "w", driver="core", backing_store=False, track_order=True) as file:
        of_all = {key: trace.attrs[key] for key in _OF_ALL if key in trace.attrs}
        for key, value in ({"Conventions": CONVENTIONS} | dict(about) | of_all).items():
            file.attrs[key] = value
        scales = {name: _write_variable(file, str(name), trace[name]) for name in trace.sizes}
        for name, scale in scales.items():
            scale.make_scale(str(name))
        for name, samples in trace.variables.items():
            if name not in scales:
                variable = _write_variable(file, str(name), samples)
                for axis, dimension in zip(variable.dims, samples.dims, strict=True):
                    axis.attach_scale(scales[dimension])
        file.flush()
        image = file.id.get_file_image()
    write_bytes(path, image)


def _write_variable(file: h5py.File, name: str, samples: xarray.Variable | xarray.DataArray) -> Any:
    # A time stamp inside the file would make every file differ.
    variable = file.create_dataset(name, data=np.ascontiguousarray(samples.values), track_times=False)
    for key in sorted(samples.attrs):
        variable.attrs[key] = samples.attrs[key]
    return variable


def read_trace(path: Path, content: bytes | None = None) -> xarray.Dataset:
    """Return the trace in a NetCDF file, read whole; of `content`, if the file was read before.

    Read through h5py, a NetCDF 4 file being an HDF5 file whose dimensions are scales: xarray's own reader takes ten
    times as long, and a report reads many traces.

    Raises:
        RecordError: Missing, damaged, too large, not a trace, or with samples in another file.
    """
    if content is None:
        try:
            real = path.resolve()  # a link to a recording is followed; `inside` checks those in a folder of results
            content = read_bounded(real.parent, real.name, LARGEST_TRACE)
        except FileNotFoundError as problem:
            raise RecordError(f"{path}: there is no such trace; a stop writes it next to its stop.json") from problem
    try:
        with h5py.File(BytesIO(content), "r") as file:
            _require_own_samples(file)
            variables = {str(name): _variable(str(name), samples) for name, samples in file.items()}
            attributes = {key: np.asarray(file.attrs[key]).reshape(()).item() for key in _OF_ALL if key in file.attrs}
    except Exception as problem:  # whatever a damaged file makes h5py raise
        raise RecordError(f"{path}: is not a NetCDF file: {problem}") from problem
    _require_trace(path, variables, attributes)
    scales = [name for name, (dimensions, _, _) in variables.items() if dimensions == (name,)]
    return xarray.Dataset(
        {name: variable for name, variable in variables.items() if name not in scales},
        coords={name: variables[name] for name in scales},
        attrs=attributes,
    )


def _require_own_samples(file: h5py.File) -> None:
    """Check that HDF5 reads no other file, and that the samples fit into memory.

    Raises:
        ValueError: A link or a variable refers to another file, or the variables are too large.
    """
    size = 0
    for name in file:
        if not isinstance(file.get(name, getlink=True), h5py.HardLink):
            raise ValueError(f"'{name}' is a link")
        samples = file[name]
        if not isinstance(samples, h5py.Dataset) or samples.external or samples.is_virtual:
            raise ValueError(f"'{name}' does not contain its samples")
        size += samples.nbytes
    if size > LARGEST_TRACE:
        raise ValueError(f"its samples take more than {LARGEST_TRACE >> 20} MiB")


_Variable = tuple[tuple[str, ...], NDArray[Any], dict[str, str]]


def _require_trace(path: Path, variables: dict[str, _Variable], attributes: dict[str, Any]) -> None:
    """Check what the rest of the program relies on in a trace: times, shapes, and numbers in units.

    Raises:
        RecordError: The first thing that is wrong.
    """
    if "time" not in variables:
        raise RecordError(f"{path}: is not a trace, it has no time axis")
    dimensions, time, about = variables["time"]
    if dimensions != ("time",) or time.dtype.kind not in "fiu" or not time.size:
        raise RecordError(
            f"{path}: time must have one dimension and one number for each sample; it has {time.dtype} of shape "
            f"{time.shape}"
        )
    if about.get("units", "s") != "s":
        raise RecordError(f"{path}: time is in '{about['units']}', a trace has it in 's'; convert it")
    if not (np.isfinite(time).all() and (np.diff(time) > 0).all()):
        raise RecordError(f"{path}: time does not rise from sample to sample; sort the samples or cut the file there")
    period = attributes.get("period", 1.0)
    if not (isinstance(period, float | int) and np.isfinite(period) and period > 0):
        raise RecordError(f"{path}: the attribute period is {period!r}; expected is a positive number of seconds")
    sizes: dict[str, int] = {}
    for name, (dimensions, values, _) in variables.items():
        if values.dtype.kind not in "fiub":
            raise RecordError(f"{path}: variable '{name}' must have numbers; it has {values.dtype}")
        if "time" in dimensions[1:]:
            raise RecordError(
                f"{path}: variable '{name}' has the dimensions {', '.join(dimensions)}; time is the first one, "
                "transpose it"
            )
        if len(set(dimensions)) < len(dimensions) or (name in dimensions and len(dimensions) > 1):
            raise RecordError(f"{path}: variable '{name}' has axes without their own dimension")
        for dimension, size in zip(dimensions, values.shape, strict=True):
            if sizes.setdefault(dimension, size) != size:
                raise RecordError(
                    f"{path}: variable '{name}' has {size} values along {dimension}, others have {sizes[dimension]}"
                )


def _variable(name: str, samples: Any) -> _Variable:
    dimensions = tuple(dimension[0].name.removeprefix("/") if len(dimension) else name for dimension in samples.dims)
    about = {key: samples.attrs[key] for key in _ATTRIBUTES if key in samples.attrs}
    # Bytes that are not text must not prevent the message.
    texts = {key: str(text).encode(errors="backslashreplace").decode() for key, text in about.items()}
    return dimensions, samples[()], texts
