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
from collections import Counter
from collections.abc import Generator, Iterable, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib import import_module
from math import prod
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.io import loadmat, whosmat

from railgrip.base.arrays import Vector
from railgrip.base.errors import EstimationError, InputError, UnitError
from railgrip.base.files import LARGEST_TABLE, require_regular
from railgrip.base.names import did_you_mean
from railgrip.base.programs import installation
from railgrip.base.units import conversion, cut, short, unit
from railgrip.recording.delimited import (
    SPELLINGS,
    Columns,
    is_hhmmss,
    read_delimited,
    seconds_of_day,
    seconds_of_stamps,
)
from railgrip.recording.table import DataTable, channel_label

FORMATS = (".csv", ".parquet", ".mat", ".mf4", ".mdf")
MDF = (".mf4", ".mdf")
"""Measurement data format of ASAM, versions 4 and 3."""

_UNIT_IN_NAME = re.compile(r".*[\[(]\s*([^\[\]()]+?)\s*[\])]\s*")


@dataclass(frozen=True, slots=True, kw_only=True)
class Series:
    """A signal as the file has it.

    Attributes:
        time: Instants [s], shape (k,); NaN if missing in the file.
        values: In the unit of the file, shape (k,); NaN if missing.
        unit: Unit according to the file, or None.
        notices: Sentences on the table that it is from.
    """

    time: Vector
    values: Vector
    unit: str | None
    notices: tuple[str, ...] = ()


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
    columns = list(dict.fromkeys(c.label for c in table.columns.values() if c.column is not None))
    if path.suffix.lower() in MDF:
        return read_mf4(path, columns)
    of_group = [name for name, column in table.columns.items() if column.group is not None]
    if of_group:
        raise EstimationError(
            f"{path.name}: [data.columns] {', '.join(of_group)} has group, which is for channels of mf4 and mdf files; "
            "remove it."
        )
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
            with _reading(path, "a csv file"):
                return read_delimited(path, separator, decimal)
        case ".parquet":
            return _parquet(path, columns)
        case _:
            return _mat(path)


def require_format(path: Path) -> None:
    """Raise an EstimationError for a file whose name has another ending than those of `FORMATS`."""
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise EstimationError(f"{path.name}: '{suffix}' is not a supported format; there is {', '.join(FORMATS)}.")


def _require_file(path: Path) -> None:
    try:
        require_regular(path, LARGEST_TABLE, if_missing=f"; name a recording ({', '.join(FORMATS)})")
    except InputError as problem:
        raise EstimationError(f"{problem}.") from problem
    require_format(path)


@contextmanager
def _reading(path: Path, what: str) -> Generator[None]:
    try:
        yield
    except EstimationError:
        raise
    except Exception as problem:  # each library raises different exceptions
        raise EstimationError(f"{path.name}: is not {what}: {cut(str(problem))}") from problem


def _require_memory(path: Path, numbers: int) -> None:
    """Refuse a file whose values take far more memory than the file has bytes, as a short one may ask for."""
    if 8 * numbers > max(LARGEST_TABLE, _COMPRESSED * path.stat().st_size):
        raise EstimationError(
            f"{path.name}: has {path.stat().st_size} bytes and asks for {numbers} values, {8 * numbers >> 20} MiB; "
            "it is damaged, or export only the signals that the estimation needs."
        )


_COMPRESSED = 30
"""Ratio of the memory of recorded signals to the size of their file that compression reaches."""


def _library(path: Path, module: str, extra: str) -> Any:
    try:
        return import_module(module)
    except ModuleNotFoundError as problem:
        raise EstimationError(f"{path.name}: to read {extra} files, first run {installation(extra)}.") from problem


def _parquet(path: Path, columns: Sequence[str] | None) -> Columns:
    parquet = _library(path, "pyarrow.parquet", "parquet")
    with _reading(path, "a parquet file"):
        about, schema = parquet.read_metadata(path), parquet.read_schema(path)
        if columns is not None:
            _all_there(path, columns, schema.names)
            columns = list(dict.fromkeys(columns))
        names = columns or schema.names
        if twice := [name for name, count in Counter(schema.names).items() if count > 1 and name in names]:
            number = schema.names.count(twice[0])
            raise EstimationError(f"{path.name}: there are {number} columns '{twice[0]}'; rename them.")
        _require_memory(path, about.num_rows * len(names))
        # Without the metadata of pandas, levels of an index are columns.
        frame = parquet.read_table(path, columns=columns).to_pandas(ignore_metadata=True)
    units = {str(name): "s" for name in frame.columns if frame[name].dtype.kind == "m"}
    return Columns(values={str(name): _without_zone(frame[name]) for name in frame.columns}, units=units)


def _without_zone(column: Any) -> Any:
    if isinstance(column.dtype, pd.DatetimeTZDtype):
        return column.dt.tz_convert("UTC").dt.tz_localize(None).to_numpy()
    if column.dtype.kind == "m":
        return column.dt.total_seconds().to_numpy()
    return column.to_numpy()


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
            found: dict[str, h5py.Dataset] = {}

            def visit(name: str, item: object) -> None:
                if isinstance(item, h5py.Dataset) and item.dtype.kind in "fiub":
                    found[name.replace("/", ".")] = item

            with h5py.File(path) as file:
                file.visititems(visit)
                _require_memory(path, sum(item.size or 0 for item in found.values()))
                for name, item in found.items():
                    collect(name, np.asarray(item[()]))
        else:
            _require_memory(path, sum(prod(shape) for _, shape, _ in whosmat(path)))
            for name, value in loadmat(path, simplify_cells=True).items():
                if not name.startswith("__"):
                    collect(name, value)
    return Columns(values=variables)


@_quietly()
def series_of_table(path: Path, file: Columns, table: DataTable, columns: Sequence[str]) -> dict[str, Series]:
    """Return columns of a table, all on its column of time; see `read_series`."""
    _all_there(path, [table.time.column, *columns], list(file.values))
    time = _instants(path, file, table)
    blocks = {name: _numbers(path, name, file) for name in columns}
    notices = list(file.notices)
    if table.time.repeats == "spread":
        time = _spread(time)
    else:
        notices += _repeated(path, time)
    if table.blank is None and is_change_driven(blocks.values()):
        raise EstimationError(
            f"{path.name}: most cells are blank, and each column has a value only where it changes; write blank = "
            "'unchanged' in [data] if a blank cell repeats the value above it, else blank = 'missing'."
        )
    if table.blank == "unchanged":
        # Several rows of an instant, such as one for each signal, are one state: that after the last of them.
        last = np.searchsorted(time, time, side="right") - 1 if _rises(time) else np.arange(time.size)
        blocks = {
            name: _filled(values)[last] if values.shape == time.shape else values for name, values in blocks.items()
        }
    series: dict[str, Series] = {}
    for name, values in blocks.items():
        if values.shape != time.shape:
            raise EstimationError(
                f"{path.name}: column '{name}' has {values.size} samples, its time '{table.time.column}' {time.size}."
            )
        unit_of_column = file.units.get(name) or unit_in_brackets(name)
        series[name] = Series(time=time, values=values, unit=unit_of_column, notices=tuple(notices))
    return series


def is_change_driven(columns: Iterable[Vector]) -> bool:
    """Return whether columns have a value only where it changes: most cells are blank, and hardly a value repeats."""
    blocks = [values for values in columns if values.ndim == 1 and np.isfinite(values).sum() > 1]
    if len(blocks) < 2 or len({values.size for values in blocks}) > 1:
        return False
    shares = [np.isnan(values).mean() for values in blocks]
    rows = np.isfinite(np.stack(blocks)).sum(axis=0)
    repeats = [np.mean(np.diff(values[np.isfinite(values)]) == 0.0) for values in blocks]
    # Loggers with several rates fill rows together; a row of changes has one or a few.
    return bool(np.median(shares) > 0.5 and np.median(rows) < len(blocks) / 2 and max(repeats) < 0.02)


def _rises(time: Vector) -> bool:
    return bool(np.isfinite(time).all() and (np.diff(time) >= 0.0).all())


def _filled(values: Vector) -> Vector:
    return np.asarray(pd.Series(values).where(np.isfinite(values)).ffill(), np.float64)


def _spread(time: Vector) -> Vector:
    """Return instants that rise evenly from each different instant to the next, as stamps that were cut."""
    known = np.flatnonzero(np.isfinite(time))
    stamps, counts = _runs(time[known])
    if stamps.size < 3:
        return time
    steps = np.append(np.diff(stamps), np.median(np.diff(stamps)))
    # The first and last group may be incomplete: they have the spacing of the fullest one.
    spacing = np.where(steps > 0.0, steps / counts, np.inf)
    usual = float(np.median(spacing))
    spacing[[0, -1]] = usual
    spread = time.copy()
    begin = stamps.copy()
    begin[0] = stamps[1] - counts[0] * usual
    place = np.concatenate([np.arange(count) for count in counts])
    spread[known] = np.repeat(begin, counts) + place * np.repeat(np.minimum(spacing, 2.0 * usual), counts)
    return spread


def _runs(time: Vector) -> tuple[Vector, NDArray[np.int64]]:
    first = np.flatnonzero(np.concatenate([[True], np.diff(time) != 0.0])) if time.size else np.zeros(0, dtype=np.int64)
    return time[first], np.diff(np.append(first, time.size))


def _repeated(path: Path, time: Vector) -> list[str]:
    """Return a sentence if most rows repeat an instant, as of stamps that were cut to seconds."""
    known = time[np.isfinite(time)]
    stamps, counts = _runs(known)
    if known.size < 10 or 2 * stamps.size > known.size:
        return []
    step = float(np.median(np.diff(stamps))) if stamps.size > 1 else 0.0
    return [
        f"{known.size - stamps.size} of {known.size} rows of {path.name} repeat an instant, {np.median(counts):.0f} "
        f"rows have each, and the next is {step:.6g} s later: stamps were cut. Only the first row of each is used; "
        "write repeats = 'spread' in time of [data] to spread the rows evenly."
    ]


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
    column: Any = _without_thousands(pd.Series(raw), file.decimal)
    numbers: Any = pd.to_numeric(column, errors="coerce")
    wrong = numbers.isna().to_numpy() & ~pd.isna(column).to_numpy()
    if file.decimal == "," and column.equals(pd.Series(raw)):  # pandas would read "50.000" as 50
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


def _without_thousands(column: Any, decimal: str) -> Any:
    """Return numbers in texts without separators of thousands, where these are certain."""
    texts: Any = column.dropna().astype(str).str.strip()
    for separator in ("." if decimal == "," else ",", "'", "\u2019", "\u00a0", "\u202f", " "):
        sign, point = re.escape(separator), re.escape(decimal)
        grouped = rf"[+-]?(?:\d{{1,3}}(?:{sign}\d{{3}})+|\d+)(?:{point}\d*)?(?:[eE][+-]?\d+)?"
        with_separator = texts.str.contains(separator, regex=False)
        # A point or comma alone may be a decimal sign.
        is_certain = separator not in ",." or (with_separator & texts.str.contains(decimal, regex=False)).any()
        if with_separator.any() and is_certain and texts.str.fullmatch(grouped).all():
            plain: Any = column.astype("string").str.strip().str.replace(separator, "", regex=False)
            return plain.str.replace(decimal, ".", regex=False)
    return column


def _instants(path: Path, file: Columns, table: DataTable) -> Vector:
    """Return the column of time in seconds; time stamps count from the first."""
    name = table.time.column
    values = file.values[name]
    text = table.time.unit or file.units.get(name) or unit_in_brackets(name) or unit_at_end(name, "s")
    is_date = np.asarray(values).dtype.kind == "M"
    if text == "timestamp" or (text is None and is_date):
        return seconds_of_stamps(path.name, name, values, table.time.order)
    if text == "hhmmss":
        return seconds_of_day(_numbers(path, name, file))
    if text is None:
        raise EstimationError(
            f"{path.name}: column '{name}' names no unit; write [data] time = {{ column = '{name}', unit = '…' }}, "
            "'timestamp' for dates with times of day."
        )
    try:
        gain, _ = conversion(unit(text), unit("s"))
    except UnitError as problem:
        raise EstimationError(f"[data.time] unit: {problem} Time stamps have the unit 'timestamp'.") from problem
    if is_date:
        raise EstimationError(f"{path.name}: column '{name}' holds time stamps; write unit = 'timestamp'.")
    numbers = _numbers(path, name, file)
    if is_hhmmss(numbers):
        raise EstimationError(
            f"{path.name}: column '{name}' has times of day as hhmmss: it jumps from 59 s to the next minute; write "
            f"time = {{ column = '{name}', unit = 'hhmmss' }} in [data]."
        )
    return numbers * gain


@_quietly()
def read_mf4(path: Path, columns: Sequence[str] | None = None) -> dict[str, Series]:
    """Return channels of an MDF file by name, each on its own instants; all when None, texts as NaN (`read_series`)."""
    _require_file(path)
    library, series = _library(path, "asammdf", "mf4"), dict[str, Series]()
    logging.getLogger("asammdf").setLevel(logging.CRITICAL)  # it raises an exception for each damage that it logs
    # Damage may show as late as in a block of samples.
    with _reading(path, "an MDF file"), _silently_collected(), library.MDF(path) as file:
        places, is_of_all = _places(file), columns is None
        if columns is None:
            columns = list(places)
        _all_there(path, [name for name in columns if name not in file.channels_db and name not in places], [*places])
        rows = [file.groups[places[name][0]].channel_group.cycles_nr for name in columns if name in places]
        _require_memory(path, 2 * sum(rows))  # with their instants
        for name in columns:
            if name not in places:
                ways = [label for label in places if label.startswith(f"{name} (")]
                raise EstimationError(
                    f"{path.name}: there are {len(ways)} channels '{name}': {', '.join(ways)}; write group = … (and "
                    "index = … if it is twice in the group) with the column in [data.columns]."
                )
            group, index = places[name]
            signal = file.get(group=group, index=index)
            values = np.asarray(signal.samples)
            if values.dtype.kind not in "fiub" or values.ndim != 1:
                if not is_of_all:
                    raise EstimationError(
                        f"{path.name}: channel '{name}' must have one number per sample; it has {values.dtype}."
                    )
                values = np.full(len(signal.timestamps), np.nan)
            series[name] = Series(
                time=np.asarray(signal.timestamps, dtype=np.float64),
                values=values.astype(np.float64),
                unit=signal.unit or None,
            )
    return series


def _places(file: Any) -> dict[str, tuple[int, int]]:
    """Return group and index of each channel by its name, or by `channel_label` where the name occurs several times."""
    masters = set(file.masters_db.items())
    places: dict[str, tuple[int, int]] = {}
    for name, where in file.channels_db.items():
        own = [place for place in where if place not in masters]
        groups = [group for group, _ in own]
        for group, index in own:
            if len(own) == 1:
                places[name] = group, index
            else:
                is_twice = groups.count(group) > 1
                places[channel_label(name, group, index if is_twice else None)] = group, index
    return places


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
