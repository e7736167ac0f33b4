"""From a user's file and its column map to a recording on an even grid, and what had to be mended on the way."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.base.arrays import Vector
from railgrip.base.errors import EstimationError, UnitError
from railgrip.base.names import did_you_mean
from railgrip.base.units import Unit, conversion, short, unit
from railgrip.recording.delimited import cause_of_step_back
from railgrip.recording.faults import Flag, Kind, Treatment, clean, find_faults, flags_of, summary
from railgrip.recording.files import Series, read_series, unit_at_end
from railgrip.recording.samples import recording_of
from railgrip.recording.table import TRUTH, Column, DataTable, factor_for
from railgrip.scenario.quantity import Magnitude

_MAX_SAMPLES = 5_000_000
"""Of a recording on its grid: a day at 50 Hz."""
_LARGEST = 1e30
"""Limit of readings in any SI unit; sums of larger numbers overflow."""
_LATEST = 1e11  # s; seconds since 1970 are 2e9, and a double still resolves microseconds there


@dataclass(frozen=True, slots=True, kw_only=True)
class FileRecording:
    """A recording out of a file.

    Attributes:
        recording: On an even grid. Its attribute `flags` holds the sentences, `columns` the name and unit of the column
            of each signal.
        flags: What was found and done, by signal and time.
    """

    recording: xarray.Dataset
    flags: tuple[Flag, ...]


def read_recording(
    path: Path, table: DataTable, units: Mapping[str, str], inputs: Sequence[str], outputs: Sequence[str]
) -> FileRecording:
    """Return the recording in a file.

    Inputs are needed at every instant, so the grid covers the time in which all of them exist, and a gap that cannot be
    bridged is refused. A reading may be missing: the filter then goes on without.

    Args:
        path: csv, parquet, mat or mf4.
        table: The column map.
        units: Of every signal of the model, SI as FMI spells it; states for columns `true_<state>`.
        inputs: Of the model.
        outputs: Of the model; all but those that the map names are missing throughout.

    Raises:
        EstimationError: What no estimate can be made of, in a sentence.
    """
    require_signals(path.name, table, units, inputs, outputs)
    flags: list[Flag] = []
    series = read_series(path, table)
    columns = _columns(path, series, table, units, inputs, flags)
    times = {name: column.time for name, column in columns.items()}
    grid = _grid(path, table, {name: time for name, time in times.items() if name in inputs} or times)
    signals: dict[str, tuple[Vector, str]] = {
        name: (np.full(grid.size, np.nan), units[name]) for name in outputs if name not in table.columns
    }
    for name, column in table.columns.items():
        target = units[name.removeprefix(TRUTH)]
        if column.value is not None:
            values = np.full(grid.size, _si(f"[data.columns] {name} value", column.value, target))
        elif name in inputs:
            source = columns[name]
            values, changes = input_on_grid(name, source.time, source.values, grid, table.period, table.longest_gap)
            _refuse_gaps(path, name, column, values, grid, table, flags)
            flags += changes
        else:
            source = columns[name]
            values, changes = on_grid(name, source.time, source.values, grid, table.period)
            # Gaps of the file: samples that were left out already have their flags.
            longest = max(table.longest_gap, 1.5 * float(np.median(np.diff(source.file_time))))
            flags += [*changes, *gaps_of(name, source.file_time, grid, longest, "gap")]
        signals[name] = values, target
    recording = recording_of(
        {name: signals[name] for name in (*table.columns, *outputs) if not name.startswith(TRUTH)},
        period=table.period,
        truth={name.removeprefix(TRUTH): signals[name] for name in table.columns if name.startswith(TRUTH)},
        start=float(grid[0]),
        name=path.stem,
    )
    notices = dict.fromkeys(notice for each in series.values() for notice in each.notices)
    recording.attrs["flags"] = [*notices, *summary(flags)]
    recording.attrs["columns"] = {
        name: (str(table.columns[name].column), column.unit) for name, column in columns.items()
    }
    return FileRecording(recording=recording, flags=tuple(flags))


class _Samples(NamedTuple):
    """The usable samples of a column in the model's unit, the instants at which the file has a number, and its unit."""

    time: Vector
    values: Vector
    file_time: Vector
    unit: str


def _columns(
    path: Path,
    series: Mapping[str, Series],
    table: DataTable,
    units: Mapping[str, str],
    inputs: Sequence[str],
    flags: list[Flag],
) -> dict[str, _Samples]:
    """Return the columns of the file by signal, converted and cleaned; errors are added to `flags`."""
    converted: dict[str, tuple[Vector, Vector, str]] = {}
    for name, column in table.columns.items():
        if column.column is None:
            continue
        target = units[name.removeprefix(TRUTH)]
        time, values = _rising(path, name, series[column.label], flags)
        unit_of_column, gain, shift = _convert_unit(path, name, column, series[column.label].unit, target)
        values = gain * values + shift
        if column.minimum is not None:
            values = np.maximum(values, _si(f"[data.columns] {name} minimum", column.minimum, target))
        converted[name] = time, np.where(np.abs(values) < _LARGEST, values, np.nan), unit_of_column
    # A reference is not a sensor: its samples are not judged.
    measured = {name: samples for name, samples in converted.items() if not name.startswith(TRUTH)}
    treatments = {name: _treatment(name, table.columns[name], table, units[name], name in inputs) for name in measured}
    numbers = {name: (time[np.isfinite(x)], x[np.isfinite(x)]) for name, (time, x, _) in measured.items()}
    possible = {name: _inside(values, treatments[name].limits) for name, (_, values) in numbers.items()}
    faults, found = find_faults({name: (t[possible[name]], x[possible[name]]) for name, (t, x) in numbers.items()})
    flags += found
    columns: dict[str, _Samples] = {}
    for name, (time, values, unit_of_column) in converted.items():
        is_number = np.isfinite(values)
        file_time = time[is_number]
        if name.startswith(TRUTH):
            time, values = file_time, values[is_number]
        else:
            left = np.ones(numbers[name][0].size, dtype=np.bool_)
            left[possible[name]] = ~faults[name]
            time, values = (samples[left] for samples in numbers[name])
            time, values, changes = clean(name, time, values, treatments[name])
            flags += changes
        if time.size < 2:
            raise EstimationError(
                f"{path.name}: {name} (column {short(table.columns[name].column)}) has {time.size} usable samples."
                + "".join(f" {flag}" for flag in flags if flag.signal == name)
            )
        columns[name] = _Samples(time, values, file_time, unit_of_column)
    return columns


def _inside(values: Vector, limits: tuple[float, float] | None) -> NDArray[np.bool_]:
    low, high = limits or (-np.inf, np.inf)
    return (values >= low) & (values <= high)


def require_signals(
    file: str, table: DataTable, units: Mapping[str, str], inputs: Sequence[str], outputs: Sequence[str]
) -> None:
    """Compare the names of a column map with the signals of a model; arguments as for `read_recording`.

    Raises:
        EstimationError: The map has names that the model lacks, or lacks inputs; each problem in one line.
    """
    signals = [*inputs, *outputs, *(TRUTH + name for name in units if name not in inputs)]
    problems: list[str] = []
    for name in table.columns:
        if name not in signals:
            hint = did_you_mean(name, signals) or f"it has {', '.join(signals)}."
            problems.append(f"[data.columns]: the model has no signal {short(name)}; {hint}")
    missing = [name for name in inputs if name not in table.columns]
    if missing:
        problems.append(
            f"{file}: [data.columns] lacks {', '.join(missing)}, which the model must know at all times; "
            "map a column or write value = '…'."
        )
    if problems:
        raise EstimationError("\n".join(problems))


def _rising(path: Path, name: str, series: Series, flags: list[Flag]) -> tuple[Vector, Vector]:
    """Return a signal on instants that rise; rows without a time are left out.

    Of rows with the same time, the first one that has a value counts.
    """
    finite = np.isfinite(series.time)
    time, values = series.time[finite], series.values[finite]
    if time.size and np.abs(time).max() > _LATEST:
        raise EstimationError(f"{path.name}: time reaches {np.abs(time).max():.3g} s; see the unit of [data.time].")
    if back := step_back(name, time):
        raise EstimationError(f"{path.name}: {back}")
    again = np.concatenate([[False], np.diff(time) == 0.0]) if time.size else np.zeros(0, dtype=np.bool_)
    repeats = flags_of("time", "time", time, again)
    if not finite.all():
        at = float(time[0]) if time.size else 0.0
        gaps = int((~finite).sum())
        repeats.append(Flag(signal="time", kind="time", begin=at, end=at, samples=gaps, remark="no time"))
    # Signals of one table share their instants, whose errors are reported once.
    flags.extend(flag for flag in repeats if flag not in flags)
    first = np.flatnonzero(~again)
    found = np.where(np.isfinite(values), np.arange(values.size), values.size)
    kept = np.minimum.reduceat(found, first) if first.size else first
    return time[first], np.where(kept < values.size, values[np.minimum(kept, values.size - 1)], np.nan)


def step_back(name: str, time: Vector) -> str | None:
    """Return a sentence on the first sample whose time is before that of the one above, with its cause; None if none.

    Args:
        name: Signal or column.
        time: Instants of its samples [s], shape (k,).
    """
    steps = np.diff(time)
    if not (steps < 0.0).any():
        return None
    row = int(np.argmax(steps < 0.0))
    before, after = float(time[row]), float(time[row + 1])
    return (
        f"time goes backwards at sample {row + 2} of {name}, from {before:.6f} s to {after:.6f} s. "
        f"{cause_of_step_back(before, after, _usual(steps))}."
    )


def _usual(steps: Vector) -> float:
    return float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0


def _convert_unit(
    path: Path, name: str, column: Column, file_unit: str | None, target: str
) -> tuple[str, float, float]:
    """Return the unit of a column, and gain and shift from its numbers to the model's unit.

    Raises:
        EstimationError: No unit is known, its dimension is another, or file and map contradict each other.
    """
    where = f"{path.name}: {name} (column {short(column.column)})"
    wanted = column.expected_unit(target)
    file_unit = file_unit or unit_at_end(column.column or "", wanted.dimension)
    text = column.unit if column.unit is not None else file_unit
    if text is None:
        raise EstimationError(f"{where} has no unit; write unit = '…' in [data.columns]; '{wanted.name}' is expected.")
    try:
        unit_of_column = unit(text)
        gain, shift = column.conversion(unit_of_column, target)
    except UnitError as problem:
        raise EstimationError(f"{where}: {problem}") from problem
    if file_unit is not None and column.unit is not None and _contradict(file_unit, unit_of_column, wanted):
        stated = unit(file_unit)
        is_same = stated.exponents == unit_of_column.exponents
        advice = "" if is_same else f", or {factor_for(stated, target)}"
        raise EstimationError(
            f"{where}: its unit in the file is '{file_unit}', in the map '{text}'; correct the map{advice}."
        )
    return text, gain, shift


def _contradict(text: str, other: Unit, wanted: Unit) -> bool:
    """Say whether what a file says of a column is another unit than the map's.

    The text in brackets may not be a unit, "p (front)", or may not say what rotates, "n [1/min]".
    """
    try:
        stated = unit(text)
    except UnitError:
        return False
    if stated.leaves_the_angle_out_of(other):
        return False
    try:
        ways = [conversion(each, wanted) for each in (stated, other)]
    except UnitError:
        return True
    return not np.allclose(*ways, rtol=1e-9, atol=0.0)


def _si(where: str, magnitude: Magnitude, target: str) -> float:
    try:
        value = magnitude.si(target)
    except ValueError as problem:
        raise EstimationError(f"{where} {problem}") from problem
    if not abs(value) < _LARGEST:
        raise EstimationError(f"{where} is {value:g} {target}, which is not a measurable value.")
    return value


def _treatment(name: str, column: Column, table: DataTable, target: str, is_input: bool) -> Treatment:
    limits = None
    if column.range is not None:
        low, high = (_si(f"[data.columns] {name} range", bound, target) for bound in column.range)
        limits = (low, high)
    return Treatment(
        spike=table.spike,
        frozen=table.frozen,
        limits=limits,
        holds=column.holds,
        # A held pressure and a released brake are exactly constant without an error.
        may_rest=column.may_rest or is_input,
    )


def _grid(path: Path, table: DataTable, times: Mapping[str, Vector]) -> Vector:
    begins = [float(time[0]) for time in times.values()] + ([] if table.begin is None else [table.begin])
    ends = [float(time[-1]) for time in times.values()] + ([] if table.end is None else [table.end])
    begin, end = max(begins), min(ends)
    count = math.floor(max((end - begin) / table.period, -1.0) + 1e-6) + 1
    if count > _MAX_SAMPLES:
        slowest = max(times, key=lambda name: float(np.max(np.diff(times[name]))))
        steps = np.diff(times[slowest])
        at = int(np.argmax(steps))
        raise EstimationError(
            f"{path.name}: from {begin:.3f} s to {end:.3f} s are {count:.3g} samples of {table.period:g} s, and "
            f"{_MAX_SAMPLES:.0e} are the most; the longest step, {steps[at]:.6g} s, follows "
            f"{times[slowest][at]:.3f} s: see the unit of [data.time], a jump in it, and period in [data]."
        )
    if count < 2:
        raise EstimationError(
            f"{path.name}: from {begin:.3f} s to {end:.3f} s nothing is left of which all inputs are known; "
            "see begin and end in [data], and that all columns cover the same time."
        )
    # The last instant is not let beyond the last sample by a rounding of 1e-16: nothing would be known there.
    return np.asarray(np.minimum(begin + np.arange(count) * table.period, end), dtype=np.float64)


def _refuse_gaps(
    path: Path, name: str, column: Column, values: Vector, grid: Vector, table: DataTable, flags: Sequence[Flag]
) -> None:
    missing = np.isnan(values)
    if missing.any():
        at = grid[int(np.argmax(missing))]
        near = [f for f in flags if f.signal == name and f.begin <= at + table.period and f.end >= at - table.period]
        raise EstimationError(
            f"{path.name}: input {name} (column '{column.column}') is missing from {at:.3f} s for "
            f"{missing.sum() * table.period:.3g} s in all, and a filter must know its inputs; cut the recording with "
            f"begin and end in [data], or raise longest_gap ({table.longest_gap:g} s) if the value can be interpolated."
            + "".join(f" {flag}" for flag in near)
        )


def on_grid(signal: str, time: Vector, values: Vector, grid: Vector, period: float) -> tuple[Vector, list[Flag]]:
    """Return a reading at every instant of `grid`, NaN where nothing is new, and how far samples were moved.

    A signal twice as fast as the grid, or more, is averaged over each period about its instant; one about as fast is
    interpolated between neighbouring samples, never across a missing one; samples of a slower one are moved to the
    nearest instants, by half a period or less, with NaN in between.

    Args:
        signal: Name, for the flags.
        time: Rising instants of the remaining samples [s], shape (k,).
        values: Shape (k,).
        grid: Even instants [s].
        period: Of the grid [s].
    """
    spacing = float(np.median(np.diff(time)))
    flags: list[Flag] = []
    if spacing > 1.5 * period:
        result = np.full(grid.size, np.nan)
        nearest = np.rint((time - grid[0]) / period).astype(np.int64)
        inside = (nearest >= 0) & (nearest < grid.size)
        result[nearest[inside]] = values[inside]
        off = float(np.max(np.abs(time[inside] - grid[nearest[inside]]), initial=0.0))
        if off > 0.01 * period:
            begin, end = float(grid[0]), float(grid[-1])
            remark = f"by up to {1e3 * off:.3g} ms"
            count = int(inside.sum())
            flags.append(Flag(signal=signal, kind="timing", begin=begin, end=end, samples=count, remark=remark))
        return result, flags
    if spacing <= 0.5 * period:
        return _average(time, values, grid, period), flags
    return interpolate(time, values, grid, 1.5 * max(spacing, period)), flags


def input_on_grid(
    signal: str, time: Vector, values: Vector, grid: Vector, period: float, longest_gap: float
) -> tuple[Vector, list[Flag]]:
    """Return a signal at every instant of `grid`, and flags of bridged gaps.

    It is interpolated between its samples.

    A fast one is averaged as in `on_grid`. What neither gives is NaN: a gap longer than `longest_gap`.
    """
    spacing = float(np.median(np.diff(time)))
    longest = max(longest_gap, 1.5 * spacing)
    samples = interpolate(time, values, grid, longest)
    if spacing <= 0.5 * period:
        means = _average(time, values, grid, period)
        samples = np.where(np.isfinite(means), means, samples)
    return samples, [
        f for f in gaps_of(signal, time, grid, 1.5 * max(spacing, period), "bridged") if f.end - f.begin <= longest
    ]


def interpolate(time: Vector, values: Vector, grid: Vector, longest_gap: float) -> Vector:
    """Return a signal interpolated at every instant of `grid`; NaN in longer gaps and beyond the ends."""
    samples = np.interp(grid, time, values, left=np.nan, right=np.nan)
    after = np.clip(np.searchsorted(time, grid, side="left"), 1, time.size - 1)
    apart = time[after] - time[after - 1]
    # An instant that has a sample needs no bridge, however far the next one is.
    exact = (np.abs(time[after] - grid) < 1e-9) | (np.abs(time[after - 1] - grid) < 1e-9)
    return np.where((apart > longest_gap) & ~exact, np.nan, samples)


def _average(time: Vector, values: Vector, grid: Vector, period: float) -> Vector:
    """Return the mean of the samples within half a period of every instant; NaN without samples."""
    place = np.floor((time - grid[0]) / period + 0.5).astype(np.int64)
    inside = (place >= 0) & (place < grid.size)
    count = np.bincount(place[inside], minlength=grid.size)
    total = np.bincount(place[inside], weights=values[inside], minlength=grid.size)
    with np.errstate(invalid="ignore"):
        return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def gaps_of(signal: str, time: Vector, grid: Vector, longest: float, kind: Kind) -> list[Flag]:
    """Return the intervals of the grid without samples for longer than `longest` [s]."""
    edges = np.concatenate([[min(float(grid[0]), float(time[0]))], time, [max(float(grid[-1]), float(time[-1]))]])
    apart = np.diff(edges)
    return [
        Flag(signal=signal, kind=kind, begin=float(edges[i]), end=float(edges[i + 1]), samples=0)
        for i in np.flatnonzero(apart > longest)
        if edges[i + 1] > grid[0] and edges[i] < grid[-1]
    ]
