"""Signals out of files: csv, parquet, mat and mf4, each by its library; the rest of the project sees arrays.

A signal comes with the instants that belong to it: in a table all columns share them, in an MDF file every channel
group has its own.
"""

import gc
import logging
import re
import sys
import traceback
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.io import loadmat

from railgrip.base.errors import EstimationError, InputError, UnitError
from railgrip.base.files import LARGEST_TABLE, require_regular
from railgrip.base.units import conversion, cut, short, unit
from railgrip.trace.delimited import read_delimited
from railgrip.trace.table import DataTable

Vector = NDArray[np.float64]

FORMATS = (".csv", ".parquet", ".mat", ".mf4")

_UNIT_IN_NAME = re.compile(r".*[\[(]\s*([^\[\]()]+?)\s*[\])]\s*")
_SUFFIXES = {
    **{"mps": "m/s", "kmh": "km/h", "mps2": "m/s2", "ms2": "m/s2", "rads": "rad/s", "radps": "rad/s"},
    **{"degps": "deg/s", "pct": "percent", "upm": "rev/min", "u/min": "rev/min"},
}
"""Spellings of units at the end of names, where slashes are unusual."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Series:
    """A signal as the file has it.

    Attributes:
        time: Instants [s], shape (k,); NaN where the file has none.
        values: In the file's unit, shape (k,); NaN where there is none.
        unit: What the file says its unit is, or None.
    """

    time: Vector
    values: Vector
    unit: str | None


def read_series(path: Path, table: DataTable) -> dict[str, Series]:
    """Return the columns that a map asks for, by the file's names.

    Raises:
        EstimationError: Missing, unreadable or of another format; a column is not there or not of numbers.
    """
    columns = list(dict.fromkeys(c.column for c in table.columns.values() if c.column is not None))
    if path.suffix.lower() == ".mf4":
        return read_mf4(path, columns)
    frame = read_table(path, [table.time.column, *columns], table.separator, table.decimal)
    return series_of_table(path, frame, table, columns)


def read_table(
    path: Path, columns: Sequence[str] | None = None, separator: str | None = None, decimal: str | None = None
) -> Mapping[str, Any]:
    """Return the columns of a table by their names, as the library of its format gives them.

    Args:
        path: csv, parquet or mat.
        columns: That are needed; all when None.
        separator: Of a csv file; found when None.
        decimal: Likewise.

    Raises:
        EstimationError: Unreadable or of another format; a column is not there.
    """
    _require_file(path)
    match path.suffix.lower():
        case ".csv":
            return _csv(path, separator, decimal)
        case ".parquet":
            return _parquet(path, columns)
        case ".mat":
            return _mat(path)
        case suffix:
            raise EstimationError(
                f"{path.name}: '{suffix}' is no format that is read here; there is {', '.join(FORMATS)}."
            )


def _require_file(path: Path) -> None:
    try:
        require_regular(path, LARGEST_TABLE)
    except InputError as problem:
        is_missing = isinstance(problem.__cause__, FileNotFoundError)
        hint = f"; name a recording ({', '.join(FORMATS)})" if is_missing else ""
        raise EstimationError(f"{problem}{hint}.") from problem


@contextmanager
def _reading(path: Path, what: str) -> Generator[None]:
    """Say of whatever a damaged file makes the reader of a format raise that it is no such file."""
    try:
        yield
    except EstimationError:
        raise
    except Exception as problem:  # each library has exceptions of its own
        raise EstimationError(f"{path.name}: is not {what}: {cut(str(problem))}") from problem


def _library(path: Path, module: str, extra: str) -> Any:
    """Return the library that reads a format and is not always installed."""
    try:
        return import_module(module)
    except ModuleNotFoundError as problem:
        raise EstimationError(
            f"{path.name}: reading {extra} files takes {module.partition('.')[0]}; install it with "
            f"`pip install 'railgrip[{extra}]'`."
        ) from problem


def _csv(path: Path, separator: str | None, decimal: str | None) -> Mapping[str, Any]:
    with _reading(path, "a csv file"):
        frame = read_delimited(path, separator, decimal)
    return {str(name): frame[name].to_numpy() for name in frame.columns}


def _parquet(path: Path, columns: Sequence[str] | None) -> Mapping[str, Any]:
    parquet = _library(path, "pyarrow.parquet", "parquet")
    with _reading(path, "a parquet file"):
        if columns is not None:
            _all_there(path, columns, parquet.read_schema(path).names)
            columns = list(dict.fromkeys(columns))
        frame = parquet.read_table(path, columns=columns).to_pandas()
    return {str(name): frame[name].to_numpy() for name in frame.columns}


def _mat(path: Path) -> Mapping[str, Any]:
    """Return the vectors of a MATLAB file; those inside structures as `structure.field`."""
    variables: dict[str, Any] = {}

    def collect(name: str, value: Any) -> None:
        if isinstance(value, dict):
            for key, element in value.items():
                collect(f"{name}.{key}", element)
        elif isinstance(value, np.ndarray) and max(value.shape, default=0) == value.size:
            variables[name] = value.ravel()

    with _reading(path, "a MATLAB file"):
        if h5py.is_hdf5(path):  # MATLAB 7.3 writes HDF5

            def visit(name: str, item: object) -> None:
                if isinstance(item, h5py.Dataset) and item.dtype.kind in "fiub":
                    collect(name.replace("/", "."), np.asarray(item[()]))

            with h5py.File(path) as file:
                file.visititems(visit)
        else:
            for name, value in loadmat(path, simplify_cells=True).items():
                if not name.startswith("__"):
                    collect(name, value)
    return variables


def series_of_table(
    path: Path, frame: Mapping[str, Any], table: DataTable, columns: Sequence[str]
) -> dict[str, Series]:
    """Return columns of a table, all on its column of time; see `read_series`."""
    _all_there(path, [table.time.column, *columns], list(frame))
    time = _instants(path, frame[table.time.column], table)
    series: dict[str, Series] = {}
    for name in columns:
        values = _numbers(path, name, frame[name], table)
        if values.shape != time.shape:
            raise EstimationError(
                f"{path.name}: column '{name}' has {values.size} samples, its time '{table.time.column}' {time.size}."
            )
        series[name] = Series(time=time, values=values, unit=unit_in_brackets(name))
    return series


def unit_in_brackets(name: str) -> str | None:
    """Return what the name of a column has in brackets, as "v [km/h]" or "v (km/h)"; it need not be a unit."""
    match = _UNIT_IN_NAME.fullmatch(name)
    # "left[1]" is the first of several, not a signal without dimension.
    return match.group(1) if match and not match.group(1).isdigit() else None


def unit_at_end(name: str, target: str) -> str | None:
    """Return the unit at the end of a name, as of "v_kmh", "v in km/h" or "speed_m_s".

    Only one of the dimension of `target` counts: "wheel_l" is the left wheel, no volume.
    """
    *_, before, last = ("", *_words(name))
    for text in (f"{before}/{last}", last) if before else ():
        with suppress(UnitError):
            source = unit(_SUFFIXES.get(text.lower(), text))
            conversion(source, unit(target))
            return source.name
    return None


def name_without_unit(name: str) -> str:
    """Return the name of a column without units in brackets or at its end."""
    bracketed = unit_in_brackets(name)
    words = _words(name if bracketed is None else re.sub(r"[\[(][^\[\]()]*[\])]\s*$", "", name))
    while len(words) > 1 and not words[-1].isdigit():
        try:
            unit(_SUFFIXES.get(words[-1].lower(), words[-1]))
        except UnitError:
            break
        words.pop()
    return "_".join(words)


def _words(name: str) -> list[str]:
    return re.split(r"[_\s]+", name.strip())


def _all_there(path: Path, columns: Sequence[str], there: Sequence[str]) -> None:
    missing = [name for name in columns if name not in there]
    if not missing:
        return
    near = get_close_matches(missing[0], there, n=1)
    hint = (
        f"did you mean '{near[0]}'?"
        if near
        else f"it has {', '.join(cut(str(name)) for name in there[:50]) or 'none'}."
    )
    if "?" in missing:
        hint = "fill in each '?' in [data.columns]; " + hint
    only = " Is its separator another one?" if len(there) == 1 and path.suffix.lower() == ".csv" else ""
    raise EstimationError(f"{path.name}: has no column {', '.join(short(name) for name in missing)}; {hint}{only}")


def _numbers(path: Path, name: str, raw: Any, table: DataTable) -> Vector:
    """Return a column as floats; empty cells are NaN."""
    values = np.asarray(raw)
    if values.ndim != 1 or values.dtype.kind == "c":
        raise EstimationError(f"{path.name}: column '{name}' wants one real number a sample.")
    if values.dtype.kind in "fiub":
        return values.astype(np.float64)
    numbers: Any = pd.to_numeric(pd.Series(raw), errors="coerce")
    wrong = numbers.isna().to_numpy() & ~pd.isna(pd.Series(raw)).to_numpy()
    if wrong.any():
        row = int(np.argmax(wrong))
        why = " Is its decimal sign another one?" if "," in str(raw[row]) and table.decimal != "," else ""
        raise EstimationError(
            f"{path.name}: column '{name}' wants numbers, sample {row + 1} of {values.size} is {short(raw[row])}.{why}"
        )
    return np.asarray(numbers, dtype=np.float64)


def _instants(path: Path, values: Any, table: DataTable) -> Vector:
    """Return a column of time in seconds; time stamps count from the first."""
    name = table.time.column
    text = table.time.unit or unit_in_brackets(name) or unit_at_end(name, "s")
    if text == "timestamp":
        try:
            stamps: Any = pd.to_datetime(pd.Series(values), utc=True)
        except (ValueError, TypeError, OverflowError) as problem:
            raise EstimationError(f"{path.name}: column '{name}' has no time stamps: {cut(str(problem))}") from None
        if stamps.isna().all():
            return np.full(len(stamps), np.nan)
        seconds = (stamps - stamps.dropna().iloc[0]).dt.total_seconds()
        return np.asarray(seconds, dtype=np.float64)
    if text is None:
        raise EstimationError(
            f"{path.name}: column '{name}' names no unit; write [data] time = {{ column = '{name}', unit = '…' }}, "
            "'timestamp' for dates with times of day."
        )
    try:
        gain, _ = conversion(unit(text), unit("s"))
    except UnitError as problem:
        raise EstimationError(f"[data.time] unit: {problem} Time stamps have the unit 'timestamp'.") from problem
    if np.asarray(values).dtype.kind == "M":
        raise EstimationError(f"{path.name}: column '{name}' holds time stamps; write unit = 'timestamp'.")
    return _numbers(path, name, values, table) * gain


def read_mf4(path: Path, columns: Sequence[str] | None = None) -> dict[str, Series]:
    """Return channels of an MDF file by name, each on its own instants; all of numbers when None; see `read_series`."""
    _require_file(path)
    library, series = _library(path, "asammdf", "mf4"), dict[str, Series]()
    logging.getLogger("asammdf").setLevel(logging.CRITICAL)  # what it logs of a damaged file, its exceptions say
    # Damage may show as late as in a block of samples.
    with _reading(path, "an MDF file"), _silently_collected(), library.MDF(path) as file:
        if columns is None:
            columns = _readable(file)
        _all_there(path, columns, list(file.channels_db))
        for name in columns:
            places = file.channels_db[name]
            if len(places) > 1:
                raise EstimationError(
                    f"{path.name}: there are {len(places)} channels '{name}'; give each a name of its own."
                )
            signal = file.get(name)
            values = np.asarray(signal.samples)
            if values.dtype.kind not in "fiub" or values.ndim != 1:
                raise EstimationError(
                    f"{path.name}: channel '{name}' wants one number a sample, it has {values.dtype}."
                )
            series[name] = Series(
                time=np.asarray(signal.timestamps, dtype=np.float64),
                values=values.astype(np.float64),
                unit=signal.unit or None,
            )
    return series


def _readable(file: Any) -> list[str]:
    """Return the channels of numbers of an MDF file whose name occurs once, without those of time."""
    places = {name: where[0] for name, where in file.channels_db.items() if len(where) == 1}
    masters = {(group, channel) for group, channel in file.masters_db.items()}
    signals = {name: file.get(name).samples for name, place in places.items() if place not in masters}
    return [name for name, values in signals.items() if values.dtype.kind in "fiub" and values.ndim == 1]


@contextmanager
def _silently_collected() -> Generator[None]:
    """Collect what an exception has left half made: the destructor of asammdf's files prints a traceback then."""
    gc.freeze()  # what was there before needs no search, which would take a third of a second
    hook = sys.unraisablehook
    try:
        yield
    except Exception as problem:
        sys.unraisablehook = lambda unraisable: None
        error: BaseException | None = problem
        while error is not None:
            traceback.clear_frames(error.__traceback__)
            error = error.__context__
        gc.collect()
        raise
    finally:
        gc.unfreeze()
        sys.unraisablehook = hook
