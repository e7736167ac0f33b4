"""Tables of text as loggers write them: encoding, separator and decimal sign are found in the file."""

import csv
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

import pandas as pd

from railgrip.base.errors import EstimationError

SEPARATORS = ("\t", ";", ",", "|")
"""In the order in which they are preferred where several split a file evenly."""

_BYTE_ORDER_MARKS = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
_LINES = 50
"""Lines after the header that a separator is judged by."""
_COMMA_NUMBER = r"\s*[+-]?(?:\d+,?\d*|,\d+)(?:[eE][+-]?\d+)?\s*"


def read_delimited(path: Path, separator: str | None = None, decimal: str | None = None) -> pd.DataFrame:
    """Return the table in a text file; separators and decimal marks are detected unless given.

    Args:
        path: The first line that is not empty has the names of the columns.
        separator: Of the columns.
        decimal: "." or ",".

    Raises:
        EstimationError: No separator splits the lines into equally many columns.
    """
    encoding = _encoding(path)
    separator = separator or _separator(path, encoding)
    frame = _table(path, encoding, separator, decimal or ".")
    if decimal is None and _has_decimal_commas(frame):
        frame = _table(path, encoding, separator, ",")
    return frame.rename(columns={name: str(name).strip() for name in frame.columns})


def _table(path: Path, encoding: str, separator: str, decimal: str) -> pd.DataFrame:
    with warnings.catch_warnings(action="error", category=pd.errors.ParserWarning):  # rows longer than the header
        return pd.read_csv(
            path,
            sep=separator,
            decimal=decimal,
            encoding=encoding,
            low_memory=False,
            skipinitialspace=True,
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


def _separator(path: Path, encoding: str) -> str:
    """Return the separator that splits the header and most lines into equally many columns."""
    with path.open(encoding=encoding, newline="") as file:
        lines = [line for _, line in zip(range(_LINES + 1), (line for line in file if line.strip()), strict=False)]
    if not lines:
        raise EstimationError(f"{path.name}: is empty; wanted are names of columns and samples.")
    for separator in SEPARATORS:
        header, *rows = csv.reader(lines, delimiter=separator, skipinitialspace=True)
        # A separator at the end of each row closes it.
        widths = Counter(len(row) - (len(row) > len(header) and not row[-1].strip()) for row in rows)
        usual = widths.most_common(1)[0][0] if widths else len(header)
        if 1 < len(header) == usual:
            return separator
    raise EstimationError(
        f"{path.name}: no separator ({', '.join(map(repr, SEPARATORS))}) splits its lines into as many columns as its "
        "first one names; remove lines above the names of the columns, or write separator = '…' in [data]."
    )


def _has_decimal_commas(frame: pd.DataFrame) -> bool:
    """Say whether a column of texts holds numbers with decimal commas only."""
    for name in frame.columns:
        if not pd.api.types.is_numeric_dtype(frame[name]):
            texts: Any = frame[name].dropna().astype(str)
            if texts.str.contains(",").any() and texts.str.fullmatch(_COMMA_NUMBER).all():
                return True
    return False
