"""Texts as loggers write them: tables, and stamps of time.

Encoding, separator, decimal sign and a row of units of a table are found in the file. A column of time has numbers,
times of day as hhmmss, or dates.
"""

import csv
import re
import warnings
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from railgrip.base.arrays import Vector
from railgrip.base.errors import EstimationError, UnitError
from railgrip.base.units import cut, short, unit

SEPARATORS = ("\t", ";", ",", "|")
"""In the order in which they are preferred where several split a file evenly."""

SPELLINGS = {
    **{"mps": "m/s", "kmh": "km/h", "mps2": "m/s2", "ms2": "m/s2", "rads": "rad/s", "radps": "rad/s"},
    **{"degps": "deg/s", "pct": "percent", "upm": "rev/min", "u/min": "rev/min"},
}
"""Spellings of units in recordings, where slashes are unusual."""

_BYTE_ORDER_MARKS = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
_LINES = 50
"""Lines after the header that a separator is judged by."""
_FOOTER = 30
"""Largest number of lines of a footer."""
_STAMP = re.compile(r"\s*\d+[-./:]\d+")
_COMMA_NUMBER = re.compile(r"\s*[+-]?(?:\d{1,3}(?:\.\d{3})+,\d*|\d+,?\d*|,\d+)(?:[eE][+-]?\d+)?\s*")
_THOUSANDS = re.compile(r"\s*[+-]?[1-9]\d{0,2}(?:,\d{3})+\s*")
"""A number whose commas may separate thousands: "50,000", but neither "0,500" nor "50,0"."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Columns:
    """The columns of a file as the library of its format gives them.

    Attributes:
        values: By name.
        units: Those that the file states apart from the names, by name.
        decimal: Decimal sign of numbers in texts.
        notices: Sentences on lines that were left out.
    """

    values: Mapping[str, Any]
    units: Mapping[str, str] = field(default_factory=dict[str, str])
    decimal: str = "."
    notices: tuple[str, ...] = ()


def read_delimited(path: Path, separator: str | None = None, decimal: str | None = None) -> Columns:
    """Return the table in a text file; separators and decimal marks are detected unless given.

    Args:
        path: The first line that is not empty has the names of the columns; the second may have their units.
        separator: Of the columns.
        decimal: "." or ",".

    Raises:
        EstimationError: No separator splits the lines into equally many columns, or commas in numbers may be decimal
            signs as well as separators of thousands.
    """
    encoding = _encoding(path)
    lines = _first_lines(path, encoding)
    separator = separator or _separator(path, [text for _, text in lines])
    header, *rows = _cells([text for _, text in lines], separator)
    units = _units(header, rows)
    repeated, footer = _other_lines(path, encoding, separator, [text for _, text in lines[: 2 if units else 1]])
    skipped = [*([lines[1][0]] if units else []), *repeated, *footer]
    notices: list[str] = []
    if repeated:
        notices.append(
            f"{path.name}: {len(repeated)} lines repeat the header, the first is line {repeated[0] + 1}; left out."
        )
    if footer:
        notices.append(
            f"{path.name}: {len(footer)} lines at the end, from line {footer[0] + 1}, are not samples; left out."
        )
    frame = _table(path, encoding, separator, decimal or ".", skipped)
    if decimal is None and _has_decimal_commas(path, frame):
        decimal = ","
        frame = _table(path, encoding, separator, decimal, skipped)
    frame.columns = _labels(header, [str(name) for name in frame.columns])
    units = {
        label: units[name.strip()] for label, name in zip(frame.columns, header, strict=False) if name.strip() in units
    }
    values = {str(name): frame[name].to_numpy() for name in frame.columns}
    return Columns(values=values, units=units, decimal=decimal or ".", notices=tuple(notices))


def _labels(header: Sequence[str], found: Sequence[str]) -> list[str]:
    """Return the names of columns without spaces at their ends; those that occur several times have their number.

    Otherwise one of them would be taken for the other.

    Args:
        header: Names as written.
        found: Names by pandas, which has one for each column.
    """
    names = [name.strip() or other for name, other in zip(header, found, strict=False)]
    counts = Counter(names)
    labels = [f"column {n}: {name}" if counts[name] > 1 else name for n, name in enumerate(names, start=1)]
    return [*labels, *found[len(labels) :]]


def _other_lines(path: Path, encoding: str, separator: str, head: Sequence[str]) -> tuple[list[int], list[int]]:
    """Return the numbers from 0 of lines that repeat the header, and of those of a footer.

    A line of the footer has fewer cells than the header names, or text in the first one alone.
    """
    columns = len(_cells(head[:1], separator)[0])
    heads, repeated, last = {line.strip() for line in head}, list[int](), list[tuple[int, str]]()
    is_past_head = 0
    with path.open(encoding=encoding, newline="") as file:
        for number, line in enumerate(file):
            text = line.strip()
            if not text:
                continue
            if text in heads:
                is_past_head += 1
                if is_past_head > len(head):
                    repeated.append(number)
                    continue
            last = [*last[-(_FOOTER - 1) :], (number, line)]
    footer: list[int] = []
    for number, line in reversed(last[1:]):
        if number == 0 or line.strip() in heads:
            break
        first, *rest = _cells([line], separator)[0]
        is_short = len(rest) + 1 < columns or not any(cell.strip() for cell in rest)
        if not is_short or not first.strip() or _is_number(first) or _STAMP.match(first):
            break
        footer.insert(0, number)
    return repeated, footer


def _table(path: Path, encoding: str, separator: str, decimal: str, skipped: Sequence[int]) -> pd.DataFrame:
    with warnings.catch_warnings(action="error", category=pd.errors.ParserWarning):  # rows longer than the header
        return pd.read_csv(
            path,
            sep=separator,
            decimal=decimal,
            encoding=encoding,
            low_memory=False,
            skipinitialspace=True,
            skiprows=list(skipped) or None,
            index_col=False,  # else a separator at the end of each row shifts the names by one column
        )


def _encoding(path: Path) -> str:
    """Return the encoding of a text: by its byte order mark, else UTF-8, else the Western one of Windows."""
    with path.open("rb") as file:
        start = file.read(3)
    for mark, encoding in _BYTE_ORDER_MARKS.items():
        if start.startswith(mark):
            return encoding
    try:
        with path.open(encoding="utf-8") as file:
            for _ in file:
                pass
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8"


def _first_lines(path: Path, encoding: str) -> list[tuple[int, str]]:
    """Return the header and the lines that a separator is judged by, with their numbers from 0, without empty lines."""
    with path.open(encoding=encoding, newline="") as file:
        written = ((number, line) for number, line in enumerate(file) if line.strip())
        lines = [line for _, line in zip(range(_LINES + 1), written, strict=False)]
    if not lines:
        raise EstimationError(f"{path.name}: is empty; expected are names of columns and samples.")
    return lines


def _cells(lines: Sequence[str], separator: str) -> list[list[str]]:
    return list(csv.reader(lines, delimiter=separator, skipinitialspace=True))


def _separator(path: Path, lines: Sequence[str]) -> str:
    """Return the separator that splits the header and most lines into equally many columns."""
    for separator in SEPARATORS:
        header, *rows = _cells(lines, separator)
        # A separator at the end of each row closes it.
        widths = Counter(len(row) - (len(row) > len(header) and not row[-1].strip()) for row in rows)
        usual = widths.most_common(1)[0][0] if widths else len(header)
        if 1 < len(header) == usual:
            return separator
    raise EstimationError(
        f"{path.name}: no separator ({', '.join(map(repr, SEPARATORS))}) splits its lines into as many columns as its "
        "first one names; remove lines above the names of the columns, or write separator = '…' in [data]."
    )


def _units(header: Sequence[str], rows: Sequence[Sequence[str]]) -> dict[str, str]:
    """Return the units in the row below the header by column; empty if that row has something else.

    A row of units has no number but "1", and a unit in half of its cells or more; others may hold "-" or a word.
    """
    cells = [cell.strip().strip("[]()").strip() for cell in rows[0]] if rows else []
    filled = [cell for cell in cells if cell not in ("", "-")]
    known = [cell for cell in filled if _is_unit(cell)]
    if len(rows) < 2 or not any(cell != "1" for cell in known) or 2 * len(known) < len(filled):
        return {}
    if any(_is_number(cell) and cell != "1" for cell in filled) or not any(map(_is_number, rows[1])):
        return {}
    return {
        name.strip(): SPELLINGS.get(cell.lower(), cell)
        for name, cell in zip(header, cells, strict=False)
        if cell not in ("", "-")
    }


def _is_unit(text: str) -> bool:
    try:
        unit(SPELLINGS.get(text.lower(), text))
    except UnitError:
        return False
    return True


def _is_number(text: str) -> bool:
    try:
        float(text.replace(",", "."))
    except ValueError:
        return False
    return True


def _has_decimal_commas(path: Path, frame: pd.DataFrame) -> bool:
    """Return whether commas in numbers are decimal signs.

    They are if a column of texts holds nothing but numbers with commas, and one of these cannot be read as a separator
    of thousands.

    Raises:
        EstimationError: All of these commas may separate thousands, or other numbers of the file have points.
    """
    commas: dict[str, list[str]] = {}
    for name in map(str, frame.columns):
        column: Any = frame[name]
        if not pd.api.types.is_numeric_dtype(column):
            texts = [str(text) for text in column.dropna().unique()]
            with_comma = [text for text in texts if "," in text]
            if with_comma and all(map(_COMMA_NUMBER.fullmatch, texts)):
                commas[name] = with_comma
    if not commas:
        return False
    first = next(iter(commas))
    where = f"{path.name}: column {short(first)} has numbers such as {short(commas[first][0].strip())}"
    points = next((str(name) for name in frame.columns if _has_points(frame[name])), None)
    if points is not None:
        raise EstimationError(
            f"{where}, and column {short(points)} numbers with points; write all numbers of the file with one decimal "
            "sign and without separators of thousands."
        )
    if all(_THOUSANDS.fullmatch(text) for texts in commas.values() for text in texts):
        raise EstimationError(
            f"{where}, whose comma is a decimal sign or separates thousands; write decimal = ',' in [data] (inspect: "
            "--decimal ,) if it is a decimal sign, else remove the separators from the file."
        )
    return True


def _has_points(column: Any) -> bool:
    """Return whether a column of numbers has fractions, which a file with decimal commas cannot have."""
    if not pd.api.types.is_float_dtype(column):
        return False
    values = column.to_numpy()
    values = values[np.isfinite(values)]
    return bool((values != np.round(values)).any())


DAY: Final = 86400.0
HOUR: Final = 3600.0
_NUMERIC_DATE = re.compile(r"(?<!\d)(\d{1,2})([./-])(\d{1,2})[./-](\d{2,4})\b")
"""A date that ends with its year; whether its day or its month is first is a custom."""
_MINUTES_AND_SECONDS = re.compile(r"(?<![\d:+-])\d+:\d+[.,]\d|^\s*\d+:\d+\s*$")
_COUNTERS: Final = {f"{bits} bits": float(2**bits) for bits in (16, 24, 31, 32)}
_TICKS: Final = (1.0, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
"""Seconds of a count."""
_STEPS: Final = 5.0
"""Number of periods within which a jump of a clock is one of its usual sizes."""


def seconds_of_stamps(file: str, name: str, values: Any, order: str | None) -> Vector:
    """Return time stamps in seconds from the first, NaN where missing.

    Args:
        file: Name of the file, for messages.
        name: Name of the column.
        values: Texts or datetimes, shape (k,).
        order: "day first" or "month first" of dates that end with their year; None to recognise it.

    Raises:
        EstimationError: A text is not a time stamp, or the order of day and month is ambiguous.
    """
    column: Any = pd.Series(values)
    if np.asarray(values).dtype.kind not in "mM":
        texts = column.dropna().astype(str)
        # "12:00:01,250" has a decimal comma.
        column = column.astype("string").str.replace(r",(\d+)\s*$", r".\1", regex=True)
        _require_seconds(file, name, texts)
        is_day_first = _is_day_first(file, name, texts, order)
    else:
        is_day_first = False
    try:
        try:
            stamps: Any = pd.to_datetime(column, utc=True, dayfirst=is_day_first)
        except ValueError:  # some have fractions of a second, others none
            stamps = pd.to_datetime(column, utc=True, dayfirst=is_day_first, format="mixed")
    except (ValueError, TypeError, OverflowError) as problem:
        raise EstimationError(f"{file}: column '{name}' has no time stamps: {cut(str(problem))}") from None
    if stamps.isna().all():
        return np.full(len(stamps), np.nan)
    seconds = (stamps - stamps.dropna().iloc[0]).dt.total_seconds()
    return np.asarray(seconds, dtype=np.float64)


def _require_seconds(file: str, name: str, texts: Any) -> None:
    """Refuse times with one colon and a fraction: pandas reads minutes and seconds, 05:12.5, as hours and minutes."""
    short_ones = texts[texts.str.contains(_MINUTES_AND_SECONDS)]
    if len(short_ones):
        raise EstimationError(
            f"{file}: column '{name}' has times such as {short(short_ones.iloc[0])}, with one colon; write hours, "
            "minutes and seconds, as 10:05:12.5, or seconds as a number. Spreadsheets save times without their hours: "
            "give the cells the format hh:mm:ss.000 before saving."
        )


def _is_day_first(file: str, name: str, texts: Any, order: str | None) -> bool:
    """Return whether the day is first in dates that end with their year.

    Dates with dots are day first. Otherwise a number above 12 decides, or a single date, whose order does not matter.
    """
    dates: Any = texts.str.extract(_NUMERIC_DATE).dropna()
    if dates.empty:  # years first: pandas would exchange their months and days
        return False
    if order is not None:
        return order == "day first"
    if (dates[1] == ".").all():
        return True
    first, second = (dates[k].astype(int) for k in (0, 2))
    is_one_date = len(dates[[0, 2, 3]].drop_duplicates()) == 1
    if not is_one_date and (dates[3].str.len() < 4).any():
        raise EstimationError(
            f"{file}: column '{name}' has dates such as {short(texts.iloc[0])}, whose year has two digits and may be "
            "first or last; if it is last, write order = 'day first' or order = 'month first' in time of [data] "
            "(inspect: --order), else write years with four digits."
        )
    if (first > 12).any() or (second > 12).any():
        return bool((first > 12).any())
    if is_one_date or (first == second).all():
        return True
    raise EstimationError(
        f"{file}: column '{name}' has dates such as {short(texts.iloc[0])}, whose day or month may be first; write "
        "order = 'day first' or order = 'month first' in time of [data] (inspect: --order)."
    )


def seconds_of_day(values: Vector) -> Vector:
    """Return the seconds of the day of numbers hhmmss.ss, shape (k,)."""
    hours, rest = np.divmod(values, 1e4)
    minutes, seconds = np.divmod(rest, 100.0)
    return HOUR * hours + 60.0 * minutes + seconds


def is_hhmmss(values: Vector) -> bool:
    """Return whether numbers are times of day as hhmmss.ss: minutes and seconds below 60, and a jump over 60 to 99."""
    numbers = values[np.isfinite(values)]
    if numbers.size < 3 or numbers.min() < 0.0 or numbers.max() >= 240000.0:
        return False
    if (numbers % 100.0 >= 60.0).any() or (numbers // 100.0 % 100.0 >= 60.0).any():
        return False
    steps = np.diff(numbers)
    usual = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0
    crosses = np.diff(numbers // 100.0) > 0.0
    jumps = np.where(np.diff(numbers // 1e4) > 0.0, steps - 4040.0, steps - 40.0)
    return bool(crosses.any() and (np.abs(jumps[crosses] - usual) <= _STEPS * usual + 1e-3).mean() > 0.5)


def cause_of_step_back(before: float, after: float, period: float) -> str:
    """Return the probable cause of a clock that runs backwards, and the remedy.

    Args:
        before: Last instant before the step [s].
        after: First instant after it [s].
        period: Usual time between samples [s].
    """
    lost, tolerance = before - after + period, _STEPS * period + 1e-6
    if abs(lost - DAY) <= max(tolerance, 1.0):
        return "A time of day passes midnight: add 86400 s to the instants after it"
    if abs(lost - HOUR) <= max(tolerance, 1.0):
        return "By one hour: daylight saving time ends, or the time zone changes; add 3600 s to the instants after it"
    for counter, count in _COUNTERS.items():
        for tick in _TICKS:
            if count * tick > 10.0 * period and abs(lost - count * tick) <= min(tolerance, 1e-3 * count * tick):
                return f"A counter of {counter} overflows: add {count * tick:.10g} s to the instants after it"
    if after < 10.0 * period + 1e-9 and before > 10.0 * period:
        return "The clock is set anew, as at the start of another recording: cut the file there"
    return "The clock is set back, or the rows are in another order: cut the file there, or restore their order"
