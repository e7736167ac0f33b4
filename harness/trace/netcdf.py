"""The NetCDF file of a trace: the only format that is written, and read without a description of its contents."""

from collections.abc import Mapping
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
