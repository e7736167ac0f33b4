"""The signals of a stop on their sample grid: an xarray data set with units, and its NetCDF file.

Dimensions are `time` [s since the brake demand], `group` and `wheelset`, both counted from 1, lead to trail;
`group_of_wheelset` says which wheelsets turn as one.
"""

from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import Any

import h5netcdf
import h5py
import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.errors import RecordError
from railgrip.formation import Formation, formation_of
from railgrip.record.atomic import write_bytes
from railgrip.signals import Signal

FILE_NAME = "trace.nc"

_ATTRIBUTES = ("units", "long_name")


_GROUPS = "group_of_wheelset"


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
            {"units": signal.unit, "long_name": signal.meaning},
        )
        for signal, block in blocks.items()
    }
    membership = {"long_name": "group that the wheelset turns with"}
    return xarray.Dataset(
        variables | {_GROUPS: (("wheelset",), 1 + formation.group_of_wheelset, membership)},
        coords={
            # Time is counted and multiplied, never summed.
            "time": (
                "time",
                np.arange(count) * period,
                {"units": "s", "long_name": "time since the brake demand"},
            ),
            "group": (
                "group",
                np.arange(1, formation.groups + 1),
                {"long_name": "group of wheelsets that turn as one"},
            ),
            "wheelset": ("wheelset", np.arange(1, formation.wheelsets + 1), {"long_name": "wheelset, lead to trail"}),
        },
    )


def formation_in(trace: xarray.Dataset) -> Formation:
    """Return the formation of the vehicle that a trace is of."""
    return formation_of(trace[_GROUPS].values.tolist())


def thinned(trace: xarray.Dataset, every: int) -> xarray.Dataset:
    """Return every so many-th sample and the last one."""
    count = trace.sizes["time"]
    kept = np.unique(np.append(np.arange(0, count, every), count - 1))
    return trace.isel(time=kept)


def write_trace(trace: xarray.Dataset, path: Path) -> None:
    """Write a trace as NetCDF 4; the same trace gives the same bytes.

    Written through h5netcdf, not through xarray, which would add fill values and attributes of its own
    version's taste.
    """
    image = BytesIO()  # HDF5 answers a full disk by a crash; a file that is made in memory is written by Python
    with h5netcdf.File(image, "w") as file:
        file.dimensions = {str(name): size for name, size in trace.sizes.items()}
        for name in (*trace.coords, *trace.data_vars):
            samples = trace[name]
            values = np.ascontiguousarray(samples.values)
            variable = file.create_variable(
                str(name),
                dimensions=tuple(str(dimension) for dimension in samples.dims),
                dtype=values.dtype,
                data=values,
                compression="gzip",
                compression_opts=1,  # three times faster than 4 for a tenth more bytes
                shuffle=True,
                track_times=False,  # a time stamp inside the file would make every file differ
            )
            for key in sorted(samples.attrs):
                variable.attrs[key] = samples.attrs[key]
    write_bytes(path, image.getvalue())


def read_trace(path: Path) -> xarray.Dataset:
    """Return the trace in a NetCDF file, read whole.

    Read through h5py, a NetCDF 4 file being an HDF5 file whose dimensions are scales: xarray's own reader takes ten
    times as long, and a report reads many traces.

    Raises:
        RecordError: Missing or not a trace.
    """
    try:
        with h5py.File(path, "r") as file:
            variables = {str(name): _variable(str(name), samples) for name, samples in file.items()}
    except FileNotFoundError as problem:
        raise RecordError(f"{path}: there is no such trace; a stop writes it beside its stop.json") from problem
    except (OSError, ValueError) as problem:
        raise RecordError(f"{path}: is not a NetCDF file: {problem}") from problem
    if "time" not in variables:
        raise RecordError(f"{path}: is not a trace, it has no time axis")
    scales = [name for name, (dimensions, _, _) in variables.items() if dimensions == (name,)]
    return xarray.Dataset(
        {name: variable for name, variable in variables.items() if name not in scales},
        coords={name: variables[name] for name in scales},
    )


def _variable(name: str, samples: Any) -> tuple[tuple[str, ...], NDArray[Any], dict[str, str]]:
    """Return dimensions, values and attributes of a variable of a NetCDF 4 file."""
    dimensions = tuple(dimension[0].name.removeprefix("/") if len(dimension) else name for dimension in samples.dims)
    return dimensions, samples[()], {key: samples.attrs[key] for key in _ATTRIBUTES if key in samples.attrs}
