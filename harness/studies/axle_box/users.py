"""Somebody's own runs: a folder of recordings, a table of labels, and a column map as every estimation has one.

Recordings are read as `railgrip.trace.read` does (csv, parquet, mat, mf4; units, gaps, outliers, sensors
that froze). Their signals: `left[1]` … `left[4]` and `right[1]` … `right[4]`, longitudinal accelerations of the axle
boxes, `lateral[1]` … `lateral[4]`, all in axes of the car, and `speed`.

The table of labels is a CSV file with the columns `file`, `friction` and, where it was not always wheelset 1 that led,
`direction` (1 or -1).
"""

import csv
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

import numpy as np

from railgrip.errors import EstimationError
from railgrip.estimators.belief import Array
from railgrip.estimators.learned.online import BOXES
from railgrip.studies.axle_box.gather import SETTLED
from railgrip.studies.axle_box.reduction import SLOW, SPECTRAL, Readings, Run, reduce
from railgrip.trace.flag import Flag, summary
from railgrip.trace.read import FileRecording, recorded
from railgrip.trace.samples import reading_of
from railgrip.trace.table import Column, DataTable, TimeColumn

UNITS: Final[Mapping[str, str]] = dict.fromkeys(BOXES, "m/s2") | {"speed": "m/s"}
"""Signals of a run, as the map of columns calls them."""
PERIOD: Final = 1 / SLOW.rate
"""s, of the grid that all recordings are put on: filters and networks are made for it."""
SLOWEST: Final = 256
"""Samples a second that an accelerometer must have: features end at 16 Hz, what is filtered away begins at 38 Hz."""
FEWEST: Final = 2
"""Runs at a speed; with one there is nothing to leave out."""


def plain_table() -> DataTable:
    """Return the map of files whose columns are called as the signals are, in SI units, time in s."""
    return DataTable(
        time=TimeColumn(column="time", unit="s"),
        period=PERIOD,
        longest_gap=0.05,
        frozen=0.5,
        spike=20.0,
        columns={name: Column(column=name, unit="m/s" if name == "speed" else "m/s**2") for name in UNITS},
    )


def read_folder(
    folder: Path, labels: Path, table: DataTable | None = None, notify: Callable[[str], None] = lambda name: None
) -> tuple[tuple[Run, ...], tuple[str, ...]]:
    """Return the labelled runs of a folder, reduced, and what was mended in which file, a sentence each.

    Args:
        table: Column map; `plain_table` unless given.
        notify: Told the name of every file as it has been read.

    Raises:
        EstimationError: A file, column or value is missing or impossible; in a sentence.
    """
    label_of, columns = read_labels(labels), table or plain_table()
    runs: list[Run] = []
    remarks: list[str] = []
    for name, (friction, backwards) in label_of.items():
        record = _recording(folder / name, columns)
        flags: list[Flag] = []
        runs.append(reduce(name, friction, _readings(name, record, columns, backwards, flags)))
        remarks += [f"{name}: {sentence}" for sentence in (*record.recording.attrs["flags"], *summary(flags))]
        notify(name)
    return tuple(runs), tuple(remarks)


def read_labels(file: Path) -> dict[str, tuple[float, bool]]:
    """Return friction, between 0 and 1, and whether wheelset 4 led, by file name.

    Raises:
        EstimationError: See `read_folder`.
    """
    rows = _rows(file, ("file", "friction"))
    out: dict[str, tuple[float, bool]] = {}
    for line, row in enumerate(rows, start=2):
        friction = _number(file, line, "friction", row["friction"])
        direction = _number(file, line, "direction", row.get("direction") or "1")
        if not 0 < friction < 1:
            raise EstimationError(f"{file}: line {line}: friction lies between 0 and 1, got {friction:g}.")
        if direction not in (1.0, -1.0):
            raise EstimationError(f"{file}: line {line}: direction is 1 or -1, got {direction:g}.")
        if row["file"] in out:
            raise EstimationError(f"{file}: line {line}: {row['file']} is labelled twice.")
        out[row["file"]] = friction, direction < 0
    if len(out) < FEWEST:
        raise EstimationError(f"{file}: it labels {len(out)} runs; training needs {FEWEST} or more.")
    return out


def _recording(file: Path, table: DataTable) -> FileRecording:
    if abs(table.period / PERIOD - 1) > 1e-6:
        raise EstimationError(
            f"[data] period is {1e6 * table.period:g} us; write '{1e6 * PERIOD:g} us', {SLOW.rate} samples a second: "
            "filters are made for it, and recordings of other rates are put on it."
        )
    missing = [name for name in UNITS if name not in table.columns]
    if missing:
        raise EstimationError(f"[data.columns] lacks {', '.join(missing)}; an estimator listens to all axle boxes.")
    return recorded(file, table, UNITS, ["speed"], list(BOXES))


def _readings(name: str, record: FileRecording, table: DataTable, backwards: bool, flags: list[Flag]) -> Readings:
    """Return what a file says of a run; `flags` is told of what was interpolated."""
    recording = record.recording
    boxes = np.column_stack([_whole(name, box, record, table.longest_gap, flags) for box in BOXES])
    there = np.flatnonzero(np.isfinite(boxes).all(axis=1))
    # Loggers do not all begin and end at once; between, nothing is missing any more.
    part = slice(there[0], there[-1] + 1) if there.size else slice(0, 0)
    boxes, speed = boxes[part], reading_of(recording, "speed")[part]
    metres = float(np.abs(speed).sum()) * PERIOD
    seconds = len(boxes) * PERIOD
    if seconds <= 2 * SPECTRAL.settling or metres <= SETTLED:
        raise EstimationError(
            f"{name}: the {seconds:.1f} s and {metres:.0f} m that all sensors cover are too little; a run takes more "
            f"than {2 * SPECTRAL.settling:g} s and {SETTLED:g} m, until filters have settled."
        )
    return Readings(
        left=boxes[:, :4], right=boxes[:, 4:8], lateral=boxes[:, 8:], speed=speed, backwards=backwards,
        rate=SLOW.rate,
    )  # fmt: skip


def _whole(name: str, box: str, record: FileRecording, longest_gap: float, flags: list[Flag]) -> Array:
    """Return an acceleration without holes: short ones are bridged, NaN stands before and after all samples.

    Raises:
        EstimationError: A hole is too long, or the sensor too slow.
    """
    values, time = reading_of(record.recording, box), record.recording["time"].values
    finite = np.flatnonzero(np.isfinite(values))
    if finite.size < 2:
        raise EstimationError(f"{name}: {box} has {finite.size} usable samples{_why(box, record)}.")
    apart = np.diff(time[finite])
    spacing = float(np.median(apart))
    if spacing > 1 / SLOWEST:
        raise EstimationError(f"{name}: {box} has {1 / spacing:.0f} samples a second; it takes {SLOWEST} or more.")
    worst = int(np.argmax(apart))
    if apart[worst] > max(longest_gap, 1.5 * spacing) + 0.5 * PERIOD:
        raise EstimationError(
            f"{name}: {box} is missing from {time[finite[worst]]:.3f} s for {apart[worst]:.3g} s{_why(box, record)}, "
            f"and a filter needs every sample; cut the recording with begin and end in [data], or raise longest_gap "
            f"({longest_gap:g} s) if it can be interpolated."
        )
    for k in np.flatnonzero(apart > 1.5 * spacing):
        begin, end = (float(time[finite[j]]) for j in (k, k + 1))
        flags.append(Flag(signal=box, kind="bridged", begin=begin, end=end, samples=0))
    return np.interp(time, time[finite], values[finite], left=np.nan, right=np.nan)


def _why(box: str, record: FileRecording) -> str:
    kinds = dict.fromkeys(flag.kind for flag in record.flags if flag.signal == box and flag.kind != "timing")
    return f" ({', '.join(kinds)})" if kinds else ""


def _rows(file: Path, columns: tuple[str, ...]) -> list[Mapping[str, str]]:
    try:
        with file.open(newline="", encoding="utf-8-sig") as stream:
            rows = csv.DictReader(stream, skipinitialspace=True)
            header = [name.strip() for name in rows.fieldnames or ()]
            rows.fieldnames = header
            missing = [name for name in columns if name not in header]
            if missing:
                raise EstimationError(
                    f"{file}: it has no column {', '.join(missing)}; it has {', '.join(header) or 'no header'}."
                )
            return list(rows)
    except FileNotFoundError as problem:
        raise EstimationError(f"there is no file {file}.") from problem
    except (OSError, UnicodeDecodeError) as problem:
        raise EstimationError(f"{file}: is not a table of labels: {problem}.") from problem


def _number(file: Path, line: int, column: str, text: str | None) -> float:
    try:
        return float(text or "")
    except ValueError as problem:
        raise EstimationError(f"{file}: line {line}: {column} is a number, got '{text or ''}'.") from problem
