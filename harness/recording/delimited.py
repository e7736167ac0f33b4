"""Tables of text as loggers write them: encoding, separator, decimal sign and a row of units are found in the file."""

import csv
import re
import warnings
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from railgrip.base.errors import EstimationError, UnitError
from railgrip.base.units import short, unit

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
class TextTable:
    """A table read from text.

    Attributes:
        frame: Its columns; a column with a cell that is not a number holds texts.
        units: Unit of a column by its name, from a row below the header.
        decimal: Decimal sign of its numbers.
        notices: Sentences on lines that were left out.
    """

    frame: pd.DataFrame
    units: Mapping[str, str]
    decimal: str
    notices: tuple[str, ...] = ()


def read_delimited(path: Path, separator: str | None = None, decimal: str | None = None) -> TextTable:
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
    frame = frame.rename(columns={name: str(name).strip() for name in frame.columns})
    return TextTable(frame=frame, units=units, decimal=decimal or ".", notices=tuple(notices))


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
