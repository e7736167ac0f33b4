"""Signals out of files: csv, parquet, mat and mf4, each by its library; the rest of the project sees arrays.

A signal comes with the instants that belong to it: in a table all columns share them, in an MDF file every channel
group has its own.
"""

import gc
import logging
import re
import sys
import traceback
import warnings
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
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
from railgrip.base.names import did_you_mean
from railgrip.base.units import conversion, cut, short, unit
from railgrip.recording.delimited import SPELLINGS, read_delimited
from railgrip.recording.table import DataTable

Vector = NDArray[np.float64]

FORMATS = (".csv", ".parquet", ".mat", ".mf4")

_UNIT_IN_NAME = re.compile(r".*[\[(]\s*([^\[\]()]+?)\s*[\])]\s*")


@dataclass(frozen=True, slots=True, kw_only=True)
class Series:
    """A signal as the file has it.

    Attributes:
        time: Instants [s], shape (k,); NaN if missing in the file.
        values: In the unit of the file, shape (k,); NaN if missing.
        unit: Unit according to the file, or None.
    """

    time: Vector
    values: Vector
    unit: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Columns:
    """The columns of a file as the library of its format gives them.

    Attributes:
        values: By name.
        units: Those that the file states apart from the names, by name.
        decimal: Decimal sign of numbers in texts.
    """

    values: Mapping[str, Any]
    units: Mapping[str, str] = field(default_factory=dict[str, str])
    decimal: str = "."


@contextmanager
def _quietly() -> Generator[None]:
    """Suppress warnings of the libraries that read files: this program reports the same problems itself."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@_quietly()
def read_series(path: Path, table: DataTable) -> dict[str, Series]:
    """Return the columns that a map asks for, by the file's names.

    Raises:
        EstimationError: Missing, unreadable or of another format; a column is not there or not of numbers.
    """
    columns = list(dict.fromkeys(c.column for c in table.columns.values() if c.column is not None))
    if path.suffix.lower() == ".mf4":
        return read_mf4(path, columns)
    file = read_table(path, [table.time.column, *columns], table.separator, table.decimal)
    return series_of_table(path, file, table, columns)


@_quietly()
def read_table(
    path: Path, columns: Sequence[str] | None = None, separator: str | None = None, decimal: str | None = None
) -> Columns:
    """Return the columns of a table.

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
            raise EstimationError(f"{path.name}: '{suffix}' is not a supported format; there is {', '.join(FORMATS)}.")


def _require_file(path: Path) -> None:
    try:
        require_regular(path, LARGEST_TABLE)
    except InputError as problem:
        is_missing = isinstance(problem.__cause__, FileNotFoundError)
        hint = f"; name a recording ({', '.join(FORMATS)})" if is_missing else ""
        raise EstimationError(f"{problem}{hint}.") from problem


@contextmanager
def _reading(path: Path, what: str) -> Generator[None]:
    try:
        yield
    except EstimationError:
        raise
    except Exception as problem:  # each library raises different exceptions
        raise EstimationError(f"{path.name}: is not {what}: {cut(str(problem))}") from problem


def _library(path: Path, module: str, extra: str) -> Any:
    try:
        return import_module(module)
    except ModuleNotFoundError as problem:
        raise EstimationError(
            f"{path.name}: reading {extra} files takes {module.partition('.')[0]}; install it with "
            f"`pip install 'railgrip[{extra}]'`."
        ) from problem


def _csv(path: Path, separator: str | None, decimal: str | None) -> Columns:
    with _reading(path, "a csv file"):
        table = read_delimited(path, separator, decimal)
    frame = table.frame
    return Columns(
        values={str(name): frame[name].to_numpy() for name in frame.columns}, units=table.units, decimal=table.decimal
    )


def _parquet(path: Path, columns: Sequence[str] | None) -> Columns:
    parquet = _library(path, "pyarrow.parquet", "parquet")
    with _reading(path, "a parquet file"):
        if columns is not None:
            _all_there(path, columns, parquet.read_schema(path).names)
            columns = list(dict.fromkeys(columns))
        frame = parquet.read_table(path, columns=columns).to_pandas()
    return Columns(values={str(name): frame[name].to_numpy() for name in frame.columns})


def _mat(path: Path) -> Columns:
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
    return Columns(values=variables)


@_quietly()
def series_of_table(path: Path, file: Columns, table: DataTable, columns: Sequence[str]) -> dict[str, Series]:
    """Return columns of a table, all on its column of time; see `read_series`."""
    _all_there(path, [table.time.column, *columns], list(file.values))
    time = _instants(path, file, table)
    series: dict[str, Series] = {}
    for name in columns:
        values = _numbers(path, name, file)
        if values.shape != time.shape:
            raise EstimationError(
                f"{path.name}: column '{name}' has {values.size} samples, its time '{table.time.column}' {time.size}."
            )
        series[name] = Series(time=time, values=values, unit=file.units.get(name) or unit_in_brackets(name))
    return series


def unit_in_brackets(name: str) -> str | None:
    """Return the text in brackets in the name of a column, as "v [km/h]" or "v (km/h)"; it may not be a unit."""
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
            source = unit(SPELLINGS.get(text.lower(), text))
            conversion(source, unit(target))
            return source.name
    return None


def name_without_unit(name: str) -> str:
    """Return the name of a column without units in brackets or at its end."""
    bracketed = unit_in_brackets(name)
    words = _words(name if bracketed is None else re.sub(r"[\[(][^\[\]()]*[\])]\s*$", "", name))
    while len(words) > 1 and not words[-1].isdigit():
        try:
            unit(SPELLINGS.get(words[-1].lower(), words[-1]))
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
    columns_there = ", ".join(cut(str(name)) for name in there[:50]) or "none"
    hint = did_you_mean(missing[0], map(str, there)) or f"it has {columns_there}."
    if "?" in missing:
        hint = "fill in each '?' in [data.columns]; " + hint
    only = " Is its separator another one?" if len(there) == 1 and path.suffix.lower() == ".csv" else ""
    raise EstimationError(f"{path.name}: has no column {', '.join(short(name) for name in missing)}; {hint}{only}")


def _numbers(path: Path, name: str, file: Columns) -> Vector:
    raw = file.values[name]
    values = np.asarray(raw)
    if values.ndim != 1 or values.dtype.kind == "c":
        raise EstimationError(f"{path.name}: column '{name}' must have one real number in each sample.")
    if values.dtype.kind in "fiub":
        return values.astype(np.float64)
    column: Any = pd.Series(raw)
    numbers: Any = pd.to_numeric(column, errors="coerce")
    wrong = numbers.isna().to_numpy() & ~pd.isna(column).to_numpy()
    if file.decimal == ",":  # pandas would read "50.000" as 50
        wrong |= column.astype(str).str.contains(".", regex=False).to_numpy()
    if wrong.any():
        row = int(np.argmax(wrong))
        signs = {",", "."} & set(str(raw[row]))
        why = f" The decimal sign of the file is '{file.decimal}'; see decimal in [data]." if signs else ""
        raise EstimationError(
            f"{path.name}: column '{name}' must have numbers, sample {row + 1} of {values.size} is {short(raw[row])}."
            f"{why}"
        )
    return np.asarray(numbers, dtype=np.float64)


def _instants(path: Path, file: Columns, table: DataTable) -> Vector:
    """Return the column of time in seconds; time stamps count from the first."""
    name = table.time.column
    values = file.values[name]
    text = table.time.unit or file.units.get(name) or unit_in_brackets(name) or unit_at_end(name, "s")
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
    return _numbers(path, name, file) * gain


@_quietly()
def read_mf4(path: Path, columns: Sequence[str] | None = None) -> dict[str, Series]:
    """Return channels of an MDF file by name, each on its own instants; all of numbers when None; see `read_series`."""
    _require_file(path)
    library, series = _library(path, "asammdf", "mf4"), dict[str, Series]()
    logging.getLogger("asammdf").setLevel(logging.CRITICAL)  # it raises an exception for each damage that it logs
    # Damage may show as late as in a block of samples.
    with _reading(path, "an MDF file"), _silently_collected(), library.MDF(path) as file:
        if columns is None:
            columns = _readable(file)
        _all_there(path, columns, list(file.channels_db))
        for name in columns:
            places = file.channels_db[name]
            if len(places) > 1:
                raise EstimationError(
                    f"{path.name}: there are {len(places)} channels '{name}'; give each its own name."
                )
            signal = file.get(name)
            values = np.asarray(signal.samples)
            if values.dtype.kind not in "fiub" or values.ndim != 1:
                raise EstimationError(
                    f"{path.name}: channel '{name}' must have one number per sample; it has {values.dtype}."
                )
            series[name] = Series(
                time=np.asarray(signal.timestamps, dtype=np.float64),
                values=values.astype(np.float64),
                unit=signal.unit or None,
            )
    return series


def _readable(file: Any) -> list[str]:
    places = {name: where[0] for name, where in file.channels_db.items() if len(where) == 1}
    masters = {(group, channel) for group, channel in file.masters_db.items()}
    signals = {name: file.get(name).samples for name, place in places.items() if place not in masters}
    return [name for name, values in signals.items() if values.dtype.kind in "fiub" and values.ndim == 1]


@contextmanager
def _silently_collected() -> Generator[None]:
    """Collect what an exception has left half made: the destructor of asammdf's files prints a traceback then."""
    gc.freeze()  # a search for the parts present before would take a third of a second
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
