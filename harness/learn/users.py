"""Somebody's own runs: a folder of recordings and a table of labels.

Each recording is a CSV file with a header: `time` [s], `speed` [m/s], `left[1]` … `left[4]` and `right[1]` …
`right[4]`, the longitudinal accelerations of the axle boxes, and `lateral[1]` … `lateral[4]` [m/s²], on an even time
grid. The table of labels is a CSV file with the columns `file`, `friction` and, where it was not always wheelset 1
that led, `direction` (1 or -1).
"""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from estimators.learned.online import BOXES
from harness.learn.gather import SLOW, Readings, Run, reduce
from harness.scenario.error import ScenarioError

Array = NDArray[np.float64]

COLUMNS: Final = ("time", "speed", *BOXES)
FEWEST: Final = 2
"""Runs at a speed; with one there is nothing to leave out."""


class DataError(ScenarioError):
    """A folder of runs or a table of labels that cannot be used."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Label:
    """What is known of a run.

    Attributes:
        friction: Between 0 and 1.
        backwards: Whether wheelset 4 led.
    """

    friction: float
    backwards: bool


def read_runs(folder: Path, labels: Path) -> list[Run]:
    """Return the labelled runs of a folder, reduced.

    Raises:
        DataError: A file, column or value is missing or impossible; names file, line and column.
    """
    known = read_labels(labels)
    return [_reduced(folder / name, label) for name, label in known.items()]


def read_labels(file: Path) -> dict[str, Label]:
    """Return the table of labels by file name.

    Raises:
        DataError: See `read_runs`.
    """
    rows = _rows(file, ("file", "friction"))
    out: dict[str, Label] = {}
    for line, row in enumerate(rows, start=2):
        friction = _number(file, line, "friction", row["friction"])
        direction = _number(file, line, "direction", row.get("direction") or "1")
        if not 0 < friction < 1:
            raise DataError(f"{file}: line {line}: friction lies between 0 and 1, got {friction:g}.")
        if direction not in (1.0, -1.0):
            raise DataError(f"{file}: line {line}: direction is 1 or -1, got {direction:g}.")
        if row["file"] in out:
            raise DataError(f"{file}: line {line}: {row['file']} is labelled twice.")
        out[row["file"]] = Label(friction=friction, backwards=direction < 0)
    if len(out) < FEWEST:
        raise DataError(f"{file}: it labels {len(out)} runs; training needs {FEWEST} or more.")
    return out


def read_table(file: Path) -> dict[str, Array]:
    """Return the columns of one recording, each of shape (n,).

    Raises:
        DataError: See `read_runs`.
    """
    header = _header(file)
    _require(file, header, COLUMNS)
    try:
        values = np.loadtxt(file, delimiter=",", skiprows=1, usecols=[header.index(c) for c in COLUMNS], ndmin=2)
    except ValueError as problem:
        raise DataError(f"{file}: a value is not a number: {problem}.") from problem
    if not np.all(np.isfinite(values)):
        row, column = np.argwhere(~np.isfinite(values))[0]
        raise DataError(
            f"{file}: line {row + 2}: {COLUMNS[column]} is {values[row, column]}; gaps must be filled before."
        )
    return dict(zip(COLUMNS, values.T, strict=True))


def _reduced(file: Path, label: Label) -> Run:
    held = read_table(file)
    rate = _rate(file, held["time"])
    boxes = np.column_stack([held[name] for name in BOXES])
    seen = Readings(
        left=boxes[:, :4], right=boxes[:, 4:8], lateral=boxes[:, 8:],
        speed=float(np.mean(np.abs(held["speed"]))), backwards=label.backwards, rate=rate,
    )  # fmt: skip
    return reduce(file.name, label.friction, seen)


def _rate(file: Path, time: Array) -> int:
    """Return the samples a second of an even grid that the filters can take."""
    if len(time) < SLOW.rate:
        raise DataError(f"{file}: {len(time)} samples are too few; a run has {SLOW.rate} or more.")
    step = (time[-1] - time[0]) / (len(time) - 1)
    # A printed time is rounded; a lost sample is a whole step.
    if step <= 0 or np.abs(np.diff(time) - step).max() > 0.5 * step:
        raise DataError(f"{file}: column time is not an even grid of rising seconds.")
    rate = round(1 / step)
    if rate != SLOW.rate:
        raise DataError(f"{file}: it has {rate} samples a second; resample it to {SLOW.rate}.")
    return rate


def _rows(file: Path, wanted: tuple[str, ...]) -> list[Mapping[str, str]]:
    _require(file, _header(file), wanted)
    with file.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream, skipinitialspace=True))


def _header(file: Path) -> list[str]:
    try:
        with file.open(newline="", encoding="utf-8") as stream:
            return [name.strip() for name in next(csv.reader(stream), [])]
    except FileNotFoundError as problem:
        raise DataError(f"there is no file {file}.") from problem


def _require(file: Path, header: list[str], wanted: tuple[str, ...]) -> None:
    missing = [name for name in wanted if name not in header]
    if missing:
        raise DataError(f"{file}: it has no column {', '.join(missing)}; it has {', '.join(header) or 'no header'}.")


def _number(file: Path, line: int, column: str, text: str) -> float:
    try:
        return float(text)
    except ValueError as problem:
        raise DataError(f"{file}: line {line}: {column} is a number, got '{text}'.") from problem
