"""A user's own runs: a folder of recordings, a table of labels and a column map, judged with the splits of the paper.

Recordings are read by `railgrip.recording.read` (csv, parquet, mat, mf4; units, gaps, outliers, frozen sensors). Their
signals are `left[1]` … `left[4]` and `right[1]` … `right[4]`, longitudinal accelerations of the axle boxes,
`lateral[1]` … `lateral[4]`, all in axes of the car, and `speed`.

The table of labels is a CSV file with the columns `file`, `friction` and optionally `direction`, 1 when wheelset 1
leads and -1 when wheelset 4 does.
"""

import csv
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from io import StringIO
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import numpy as np
from pydantic import Field, StrictInt

from railgrip.base.errors import EstimationError, InputError
from railgrip.base.files import LARGEST_TABLE, read_text
from railgrip.estimation.axle_box.evaluate import (
    Score,
    TrainingRecipe,
    average,
    best_of,
    judge,
    within_runs,
    without_each,
)
from railgrip.estimation.axle_box.instrumented_car import SETTLED, SLOW, SPECTRAL, LabelledRun, Readings, reduce
from railgrip.estimation.axle_box.training import estimators_of, general
from railgrip.estimators.belief import Array
from railgrip.estimators.learned.preprocessing import BOXES, COMBINATIONS
from railgrip.estimators.learned.trained import Trained
from railgrip.recording.faults import Flag, summary
from railgrip.recording.read import FileRecording, read_recording
from railgrip.recording.samples import reading_of
from railgrip.recording.table import Column, DataTable, TimeColumn
from railgrip.scenario.load import read_toml, validate_table
from railgrip.scenario.table import Name, Table, one_of


class RunsTable(Table):
    """[runs]: paths of recordings and labels, relative to the folder of the file."""

    folder: str
    labels: str


class NetworkTable(Table):
    """[network]: the networks of the paper."""

    inputs: Annotated[str, one_of(COMBINATIONS, "; ")] = "longitudinal"
    bias: Literal["inside", "outside"] = "inside"
    starts: Annotated[StrictInt, Field(ge=1, le=100)] = 5

    def recipe(self) -> TrainingRecipe:
        """Return the recipe of their training."""
        return TrainingRecipe(inputs=self.inputs, bias=self.bias, starts=self.starts)


class RecordingsFile(Table):
    """Inputs of the training on a user's runs."""

    name: Name
    runs: RunsTable
    network: NetworkTable = NetworkTable()
    data: DataTable | None = None


def read_recordings_file(file: Path) -> RecordingsFile:
    """Return the inputs in a TOML file.

    Raises:
        ScenarioError: The file is missing or invalid; it lists all problems.
    """
    return validate_table(RecordingsFile, read_toml(file), directory=file.parent, origin=file.name)


MEMBERS = 20

FEWEST = 4
"""Minimum number of runs for an interval, because some must be outside of every draw."""


def judge_recordings(
    runs: Sequence[LabelledRun], recipe: TrainingRecipe, run_all: Callable[[Sequence[Callable[[], Any]]], Sequence[Any]]
) -> tuple[list[dict[str, Any]], dict[str, Trained]]:
    """Return scores of estimators trained on a user's runs, and the estimators by the name of their files.

    Args:
        recipe: Of the networks of the paper, one for each speed class.
        run_all: Returns the results of tasks, which it may run in other processes.

    Returns:
        Rows with `estimator`, `judged_on`, `mph`, None for all speeds, and the fields of `Score`.

    Raises:
        EstimationError: There are too few runs.
    """
    if len(runs) < FEWEST:
        raise EstimationError(f"there are {len(runs)} labelled runs; training and judging need {FEWEST} or more.")
    several = _classes(runs)
    tasks: dict[tuple[str, int], Callable[[], Any]] = {("whole", 0): partial(general, runs, MEMBERS)}
    for group, runs_of_group in several.items():
        tasks["within", group] = partial(within_runs, runs_of_group, recipe)
        tasks["without one", group] = partial(without_each, runs_of_group, recipe)
        tasks["network", group] = partial(best_of, runs_of_group, recipe)
    tasks |= {("each", k): partial(_without, runs, k, MEMBERS) for k in range(len(runs))}
    results: dict[tuple[str, int], Any] = dict(zip(tasks, run_all(list(tasks.values())), strict=True))
    rows = [
        {"estimator": "network of the paper", "judged_on": where, "mph": group, **asdict(results[name, group])}
        for name, where in (("within", "last 20 % of runs seen"), ("without one", "a run left out"))
        for group in several
    ]
    whole = average(results["each", k] for k in range(len(runs)))
    rows.append({"estimator": "all speeds", "judged_on": "a run left out", "mph": None, **asdict(whole)})
    networks = {group: results["network", group] for group in several}
    return rows, estimators_of(results["whole", 0][0], networks, recipe)


def _classes(runs: Sequence[LabelledRun]) -> dict[int, list[LabelledRun]]:
    groups = {g: [run for run in runs if run.group == g] for g in sorted({run.group for run in runs})}
    return {g: runs_of_group for g, runs_of_group in groups.items() if len(runs_of_group) > 1}


def _without(runs: Sequence[LabelledRun], place: int, members: int) -> Score:
    estimator, mean = general([run for k, run in enumerate(runs) if k != place], members)
    return judge(estimator, mean, [runs[place]])


UNITS: Final[Mapping[str, str]] = dict.fromkeys(BOXES, "m/s2") | {"speed": "m/s"}
"""Signals of a run in the column map, and their units."""
PERIOD: Final = 1 / SLOW.rate
"""Period of the grid of all recordings, s; filters and networks require it."""
SLOWEST: Final = 256
"""Minimum sampling rate of an accelerometer [Hz]: features end at 16 Hz, the low-pass begins at 38 Hz."""
FEWEST_LABELS: Final = 2
"""Minimum number of labelled runs, because one is left out."""


def plain_table() -> DataTable:
    """Return the map of files whose columns have the names of the signals, in SI units, time in s."""
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
) -> tuple[tuple[LabelledRun, ...], tuple[str, ...]]:
    """Return the labelled runs of a folder, reduced, and a sentence for each repair.

    Args:
        table: Column map; `plain_table` unless given.
        notify: Called with the name of every file after it is read.

    Raises:
        EstimationError: A file, column or value is missing or impossible.
    """
    label_of, columns = read_labels(labels), table or plain_table()
    runs: list[LabelledRun] = []
    remarks: list[str] = []
    for name, (friction, backwards) in label_of.items():
        record = _recording(folder / name, columns)
        flags: list[Flag] = []
        runs.append(reduce(name, friction, _readings(name, record, columns, backwards, flags)))
        remarks += [f"{name}: {sentence}" for sentence in (*record.recording.attrs["flags"], *summary(flags))]
        notify(name)
    return tuple(runs), tuple(remarks)


def read_labels(file: Path) -> dict[str, tuple[float, bool]]:
    """Return friction, between 0 and 1, and whether wheelset 4 leads, by file name.

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
    if len(out) < FEWEST_LABELS:
        raise EstimationError(f"{file}: it labels {len(out)} runs; training needs {FEWEST_LABELS} or more.")
    return out


def _recording(file: Path, table: DataTable) -> FileRecording:
    if abs(table.period / PERIOD - 1) > 1e-6:
        raise EstimationError(
            f"[data] period is {1e6 * table.period:g} us; write '{1e6 * PERIOD:g} us', {SLOW.rate} samples a second: "
            "filters require it, and recordings of other rates are resampled."
        )
    missing = [name for name in UNITS if name not in table.columns]
    if missing:
        raise EstimationError(f"[data.columns] lacks {', '.join(missing)}; an estimator needs all axle boxes.")
    return read_recording(file, table, UNITS, ["speed"], list(BOXES))


def _readings(name: str, record: FileRecording, table: DataTable, backwards: bool, flags: list[Flag]) -> Readings:
    recording = record.recording
    boxes = np.column_stack([_whole(name, box, record, table.longest_gap, flags) for box in BOXES])
    there = np.flatnonzero(np.isfinite(boxes).all(axis=1))
    # Loggers begin and end at different instants; between them no sample is missing.
    part = slice(there[0], there[-1] + 1) if there.size else slice(0, 0)
    boxes, speed = boxes[part], reading_of(recording, "speed")[part]
    metres = float(np.abs(speed).sum()) * PERIOD
    seconds = len(boxes) * PERIOD
    if seconds <= 2 * SPECTRAL.settling or metres <= SETTLED:
        raise EstimationError(
            f"{name}: the {seconds:.1f} s and {metres:.0f} m that all sensors cover are too little; filters settle for "
            f"{2 * SPECTRAL.settling:g} s and {SETTLED:g} m, record a longer run."
        )
    return Readings(boxes=boxes, speed=speed, backwards=backwards)


def _whole(name: str, box: str, record: FileRecording, longest_gap: float, flags: list[Flag]) -> Array:
    """Return an acceleration with short gaps interpolated, and NaN before and after all samples.

    Raises:
        EstimationError: A gap is too long, or the sensor too slow.
    """
    values, time = reading_of(record.recording, box), record.recording["time"].values
    finite = np.flatnonzero(np.isfinite(values))
    if finite.size < 2:
        raise EstimationError(f"{name}: {box} has {finite.size} usable samples{_why(box, record)}.")
    apart = np.diff(time[finite])
    spacing = float(np.median(apart))
    if spacing > 1 / SLOWEST:
        raise EstimationError(
            f"{name}: {box} has {1 / spacing:.0f} samples a second; estimators need {SLOWEST} or more."
        )
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


def _rows(file: Path, columns: tuple[str, ...]) -> Sequence[Mapping[str, str]]:
    try:
        table = csv.DictReader(StringIO(read_text(file, LARGEST_TABLE)), skipinitialspace=True)
        header = [name.strip() for name in table.fieldnames or ()]
        table.fieldnames = header
        rows = list(table)
    except InputError as problem:
        raise EstimationError(f"{problem}.") from problem
    except csv.Error as problem:
        raise EstimationError(f"{file}: is not a table of labels: {problem}.") from problem
    missing = [name for name in columns if name not in header]
    if missing:
        raise EstimationError(
            f"{file}: it has no column {', '.join(missing)}; it has {', '.join(header) or 'no header'}."
        )
    return rows


def _number(file: Path, line: int, column: str, text: str | None) -> float:
    try:
        return float(text or "")
    except ValueError as problem:
        raise EstimationError(f"{file}: line {line}: {column} is a number, got '{text or ''}'.") from problem
