"""The user's own curves: CSV files with one axis, and one column of a quantity or one for each wheelset or group."""

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import InputError
from railgrip.base.files import read_text

_LARGEST = 64 << 20  # bytes; a point every 0.1 m over 100 km takes a third of it


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """Friction at points of an axis; straight lines between them, constant beyond.

    Attributes:
        over: What the axis is: time [s] or distance [m].
        axis: Rising, shape (n,), n ≥ 2.
        mu0: Shape (n, 1), for the first wheelset, or (n, wheelsets).
    """

    over: Literal["time", "distance"]
    axis: NDArray[np.float64]
    mu0: NDArray[np.float64]


def read_curve(path: Path) -> Curve:
    """Read the columns time [s] or distance [m], and mu0 or mu0_1 … mu0_n.

    Raises:
        ValueError: What is wrong and in which line, without the file's name.
    """
    over, axis, mu0 = read_columns(path, axes={"time": "s", "distance": "m"}, name="mu0", span=(0.0, 1.0), above=True)
    return Curve(over="time" if over == "time" else "distance", axis=axis, mu0=mu0)


def read_columns(
    path: Path, *, axes: Mapping[str, str], name: str, span: tuple[float, float], above: bool = False
) -> tuple[str, NDArray[np.float64], NDArray[np.float64]]:
    """Read a quantity over a rising axis: which axis it is, its points, shape (n,), and values, shape (n, columns).

    Args:
        path: Of a CSV file whose first line names its columns.
        axes: Name → unit of what the axis may be; one of them.
        name: Of the quantity: one column, or name_1 … name_n.
        span: Least and largest value.
        above: The least value is none.

    Raises:
        ValueError: What is wrong and in which line, without the file's name.
    """
    try:
        lines = enumerate(csv.reader(read_text(path, _LARGEST).splitlines()), start=1)
        rows = [(line, row) for line, row in lines if any(cell.strip() for cell in row)]
    except (InputError, csv.Error) as problem:
        raise ValueError(f"is not a table of text, as csv files are ({problem})") from problem
    if not rows:
        raise ValueError(f"is empty; the first line names the columns, such as time,{name}")
    header = [cell.strip() for cell in rows[0][1]]
    each = [f"{name}_{number}" for number in range(1, len(header))]
    reserved_names = {*axes, name, *each}
    axes_in_header = [axis for axis in axes if axis in header]
    columns = next((expected for expected in ([name], each) if set(header) == {*axes_in_header, *expected}), None)
    if len(axes_in_header) != 1 or columns is None or len(header) != 1 + len(columns):
        expected = " or ".join(f"{axis} [{unit}]" for axis, unit in axes.items())
        raise ValueError(
            f"has {len(header)} columns; its first line wants to name {expected}, and {name} for all or {name}_1, "
            f"{name}_2 … for each, and names of these {', '.join(sorted({*header} & reserved_names)) or 'none'}"
        )
    if len(rows) < 3:
        raise ValueError(f"has {len(rows) - 1} rows of numbers; a curve takes two or more")
    values = _numbers(rows[1:], len(header))
    axis = values[:, header.index(axes_in_header[0])]
    quantity = values[:, [header.index(column) for column in columns]]
    if not np.all(np.diff(axis) > 0):
        line = rows[1:][int(np.argmin(np.diff(axis) > 0)) + 1][0]
        raise ValueError(f"line {line}: {axes_in_header[0]} does not rise")
    least, most = span
    inside = np.all(((quantity > least) if above else (quantity >= least)) & (quantity <= most), axis=1)
    if not np.all(inside):
        line = rows[1:][int(np.argmin(inside))][0]
        raise ValueError(
            f"line {line}: {name} must be {'above' if above else 'at least'} {least:g} and at most {most:g}"
        )
    return axes_in_header[0], axis, quantity


def _numbers(rows: Sequence[tuple[int, list[str]]], count: int) -> NDArray[np.float64]:
    """Return the numbers of rows, each with the number of its line, shape (rows, count)."""
    try:
        values = np.array([row for _, row in rows], dtype=np.float64)
        if values.shape[1:] == (count,) and np.isfinite(values).all():
            return values
    except ValueError:  # a cell is no number, or rows differ in length
        pass
    line = next(line for line, row in rows if not _is_of_numbers(row, count))
    # What stands there is not repeated: a user of somebody else's scenario may have replaced the file.
    raise ValueError(f"line {line}: {count} finite numbers are wanted")


def _is_of_numbers(row: Sequence[str], count: int) -> bool:
    try:
        return len(row) == count and all(math.isfinite(float(cell)) for cell in row)
    except ValueError:
        return False
