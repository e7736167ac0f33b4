"""The user's own friction curve: a CSV file with one axis and one column of mu0 or one for each wheelset."""

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray


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
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            numbered = enumerate(csv.reader(file), start=1)
            rows = [(line, row) for line, row in numbered if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError, csv.Error) as problem:
        raise ValueError("is not a table of text, as csv files are") from problem
    if not rows:
        raise ValueError("is empty; the first line names the columns, such as time,mu0")
    header = [cell.strip() for cell in rows[0][1]]
    each = [f"mu0_{number}" for number in range(1, len(header))]
    known = {"time", "distance", "mu0", *each}
    axes = [name for name in ("time", "distance") if name in header]
    columns = next((wanted for wanted in (["mu0"], each) if set(header) == {*axes, *wanted}), None)
    if len(axes) != 1 or columns is None or len(header) != 1 + len(columns):
        raise ValueError(
            f"has {len(header)} columns; its first line wants to name time [s] or distance [m], and mu0 for all "
            "wheelsets or mu0_1, mu0_2 … for each, and names of these "
            f"{', '.join(sorted({*header} & known)) or 'none'}"
        )
    values = np.array([_numbers(line, row, len(header)) for line, row in rows[1:]])
    if len(values) < 2:
        raise ValueError(f"has {len(values)} rows of numbers; a curve takes two or more")
    axis = values[:, header.index(axes[0])]
    mu0 = values[:, [header.index(column) for column in columns]]
    if not np.all(np.diff(axis) > 0):
        line = rows[1:][int(np.argmin(np.diff(axis) > 0)) + 1][0]
        raise ValueError(f"line {line}: {axes[0]} does not rise")
    if not np.all((mu0 > 0) & (mu0 <= 1)):
        line = rows[1:][int(np.argmin(np.all((mu0 > 0) & (mu0 <= 1), axis=1)))][0]
        raise ValueError(f"line {line}: mu0 must be above 0 and at most 1")
    return Curve(over="time" if axes[0] == "time" else "distance", axis=axis, mu0=mu0)


def _numbers(line: int, row: list[str], count: int) -> list[float]:
    try:
        numbers = [float(cell) for cell in row]
    except ValueError:
        numbers = []
    if len(numbers) != count or not np.all(np.isfinite(numbers)):
        # What stands there is not repeated: whoever runs a scenario of others may have named a file of his own.
        raise ValueError(f"line {line}: {count} finite numbers are wanted")
    return numbers
