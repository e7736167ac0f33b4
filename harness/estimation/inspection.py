"""Inspect a recording, and propose the table [data] by which an estimation reads it."""

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import accumulate
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd
from scipy.optimize import linear_sum_assignment

from railgrip.base.errors import EstimationError, UnitError
from railgrip.base.names import ElementName, known_names
from railgrip.base.units import conversion, short, turning_of, unit
from railgrip.estimation.sources import ACCELERATION, UNITS_OF_RUN, signals_of
from railgrip.estimation.spec import ModelParameter, Specification, load_specification, model_parameters
from railgrip.fmi.draft import OTHER_NAMES, bare_name, likeness
from railgrip.recording.delimited import is_hhmmss
from railgrip.recording.files import (
    MDF,
    Columns,
    Series,
    is_change_driven,
    name_without_unit,
    read_mf4,
    read_table,
    series_of_table,
    unit_at_end,
    unit_in_brackets,
)
from railgrip.recording.read import step_back
from railgrip.recording.table import DataTable, TimeColumn
from railgrip.scenario.file import is_file

_NAMES = {
    "time": "t zeit timestamp zeitstempel datetime date datum uhrzeit seconds elapsed",
    "speed": "v_gps v_gnss v_radar v_optical geschwindigkeit v_ist ground_speed",
    "wheelset_speed": "rpm drehzahl radsatzdrehzahl wheelset axle speed_axle speed_wheel n_axle raddrehzahl",
    "cylinder_pressure": "p pc p_c bc bc_pressure bremszylinder bremszylinderdruck c_druck p_bc druck",
    "pad_force": "f force clamp_force brake_force pad belagkraft bremskraft",
    "acceleration": "acc accel beschleunigung",
    "acceleration_along": "acceleration a acc accel a_x ax acc_x beschleunigung longitudinal_acceleration",
    "latitude": "lat breitengrad breite gps_lat",
    "longitude": "lon long lng laengengrad laenge gps_lon",
    "height": "altitude alt hoehe elevation gps_alt z",
    "driving": "traction drive traktion power_on",
    "braking": "brake bremse bremsen brake_applied",
    "wheel_torque": "torque moment",
    "deflection": "spring suspension federweg",
}
"""Other names of signals in recordings, in addition to those of plants."""

_FROM_ANOTHER = {
    "pad_force": 'a pressure becomes a force with unit = "bar", factor = "8 kN/bar", offset = -4.0, minimum = "0 N"; '
}
"""Remark on a column with another quantity than the signal."""
_NOT_MEASURED = {"cmd", "command", "demand", "setpoint", "target", "soll", "init", "initial"}
"""Words in names of columns with commands and initial values, which are not measurements."""
_MAY_REST = {"speed", "wheelset_speed", "latitude", "longitude", "height"}
"""Readings that may be exactly constant: while a train is at rest, or a wheelset is locked."""
_LEAST = 0.6
"""Similarity of names below which a column is not recognised."""
_DEGREES = ("latitude", "longitude")
_MAX_ACCELEROMETERS = 16
_BRIDGED = 1.0
"""Longest gap of an input that a proposal interpolates over [s]."""
_GAP = 2.5
"""Number of periods without a sample that counts as a gap."""


_RequiredSignal = tuple[str, bool]
"""Unit of a signal of the model, and whether the model requires the signal."""

_UNKNOWN = "?"
"""Placeholder that the reader of a proposal has to replace."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnMatch:
    """A column of a recording.

    Attributes:
        name: Name in the file.
        unit: Unit in the file, in brackets or at the end of the name, or None.
        samples: Number of its values.
        period: Median time between them [s].
        begin: Time of the first value [s].
        end: Time of the last value [s].
        low: Minimum, in its unit.
        high: Maximum, in its unit.
        gaps: Time and length of each interval without a value for more than `_GAP` periods [s].
    """

    name: str
    unit: str | None
    samples: int
    period: float
    begin: float
    end: float
    low: float
    high: float
    gaps: tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Inspection:
    """The content of a recording.

    Attributes:
        findings: Description of each column of numbers.
        texts: Names of the other columns, those with fewer than two numbers included.
        signals: Signal → column that was recognised.
        proposal: Estimation as TOML that reads the recording.
        unrecognised: Signals of the proposal whose column or unit the reader has to complete.
        parameters: Vehicle data that the model needs, with their defaults.
        notices: Sentences on the file and its clock.
    """

    findings: tuple[ColumnMatch, ...]
    texts: tuple[str, ...]
    signals: Mapping[str, str]
    proposal: str
    unrecognised: tuple[str, ...]
    parameters: tuple[ModelParameter, ...]
    notices: tuple[str, ...] = ()


def inspect_recording(
    path: Path,
    estimation: Path,
    time: str | None = None,
    decimal: Literal[".", ","] | None = None,
    train: str | None = None,
    order: Literal["day first", "month first"] | None = None,
) -> Inspection:
    """Return the content of a recording, and a proposal for an estimation that reads it.

    Args:
        path: Recording: csv, parquet, mat, mf4 or mdf.
        estimation: File or name of the estimation whose signals are searched for.
        time: Column of time; None to recognise it.
        decimal: Decimal sign of a csv file; None to detect it.
        train: Train of the prediction, a name or a file; None for that of the estimation.
        order: Order of dates that end with their year; None to recognise it.

    Raises:
        ScenarioError: The estimation cannot be read.
        EstimationError: The file cannot be read, no column of time is recognised, or no other has two numbers at rising
            times.
    """
    specification = load_specification(estimation, {} if train is None else {"model.train": train})
    # The proposal may be in another folder than the current one.
    base = _found_anywhere(str(estimation))
    clock, series, texts, blank, notices = _read(path, time, decimal, order)
    backs = (step_back(short(name), column.time[np.isfinite(column.time)]) for name, column in series.items())
    # The columns of a table have one clock.
    notices += [f"{path.name}: {back} `railgrip estimate` refuses the file." for back in filter(None, backs)][:1]
    findings = [finding for name, column in series.items() for finding in _findings(name, column)]
    if not findings:
        notices.append(
            f"{path.name}: has no column besides its time with two numbers at rising times; name another recording, or "
            "the column of time with --time."
        )
        raise EstimationError("\n".join(notices))
    wanted = _required_signals(specification)
    recognised = _recognise(findings, wanted)
    period = min(finding.period for finding in recognised.values() or findings)
    lines, unrecognised = _columns(wanted, recognised)
    parameters = tuple(model_parameters(specification))
    head = [
        f"# How `railgrip estimate` reads {path.name}. Correct what you know better, and fill in each '{_UNKNOWN}'.",
        f"extends = {_toml(base)}",
        f"name = {_toml(re.sub(r'[^A-Za-z0-9_.-]', '_', path.stem))}",
        "",
        *([] if train is None else ["[model]", f"train = {_toml(_found_anywhere(train))}", ""]),
        "[model.parameters]",
        "# The filter uses these values of the library. Remove the # in front of a line to give that of your vehicle.",
        *map(_parameter_line, parameters),
        "",
        "[data]",
        _clock_line(clock, path),
        f'period = "{_shortest(1e3 * period, 1e3 * _resolution(recognised.values() or findings)):g} ms"',
        *([] if blank is None else [f"blank = {_toml(blank)}  # a column has a value only where it changes"]),
        *([] if decimal is None else [f"decimal = {_toml(decimal)}"]),
        *_gap_lines([finding for name, finding in recognised.items() if wanted[name][1]], period),
        'frozen = "2 s"  # readings that repeat exactly for longer are left out',
        "spike = 8.0  # so are samples as many deviations off their neighbours",
        "",
        "[data.columns]",
    ]
    return Inspection(
        findings=tuple(_with_unit(finding, recognised, wanted) for finding in findings),
        texts=(*texts, *(name for name in series if name not in {finding.name for finding in findings})),
        signals={signal: finding.name for signal, finding in recognised.items()},
        proposal="\n".join([*head, *lines]) + "\n",
        unrecognised=tuple(unrecognised),
        parameters=parameters,
        notices=tuple(notices),
    )


def _found_anywhere(name: str) -> str:
    return str(Path(name).resolve()) if is_file(Path(name)) else name


def _parameter_line(parameter: ModelParameter) -> str:
    key = _toml(parameter.name) if "[" in parameter.name else parameter.name
    value = f"{parameter.value:g}" if parameter.unit == "1" else _toml(f"{parameter.value:g} {parameter.unit}")
    return f"# {key} = {value}  # {' '.join(parameter.description.split())}"


# ---- what the file holds ----------------------------------------------------------------------------------------


def _read(
    path: Path, time: str | None, decimal: str | None, order: Literal["day first", "month first"] | None
) -> tuple[TimeColumn, dict[str, Series], list[str], Literal["unchanged"] | None, list[str]]:
    """Return the column of time, those of numbers, the names of the others, what blank cells mean, and notices."""
    if path.suffix.lower() in MDF:
        return TimeColumn(column="time", unit="s"), read_mf4(path), [], None, []
    file = read_table(path, decimal=decimal)
    frame = file.values
    clock = _clock(path, file, time).model_copy(update={"order": order})
    numbers = [name for name, values in frame.items() if name != clock.column and _is_numeric(values)]
    notices: list[str] = []
    instants = pd.to_numeric(pd.Series(frame[clock.column]), errors="coerce") if clock.unit in (None, "s") else None
    if instants is not None and is_hhmmss(np.asarray(instants, dtype=float)):
        clock = clock.model_copy(update={"unit": "hhmmss"})
        notices.append(f"{path.name}: {short(clock.column)} has times of day as hhmmss, not seconds.")

    def read(clock: TimeColumn, blank: Literal["unchanged", "missing"]) -> dict[str, Series]:
        time = clock.model_copy(update={"unit": clock.unit or "s"})
        table = DataTable(time=time, period=1.0, longest_gap=1.0, frozen=1.0, spike=8.0, columns={}, blank=blank)
        return series_of_table(path, file, table, numbers)

    series = read(clock, "missing")
    notices += dict.fromkeys(notice for each in series.values() for notice in each.notices)
    if any("repeats = 'spread'" in notice for notice in notices):
        clock = clock.model_copy(update={"repeats": "spread"})
        series = read(clock, "missing")
    blank = None
    if is_change_driven(each.values for each in series.values()):
        blank = "unchanged"
        notices.append(f"{path.name}: most cells are blank; a blank cell is taken to repeat the value above it.")
        series = read(clock, blank)
    return clock, series, [name for name in frame if name not in (clock.column, *numbers)], blank, notices


def _is_numeric(values: Any) -> bool:
    array = np.asarray(values)
    if array.dtype.kind == "M":
        return False
    if array.ndim != 1 or array.dtype.kind in "fiub":
        return array.ndim == 1
    filled: Any = pd.Series(values).dropna()
    if len(filled) and filled.map(lambda value: hasattr(value, "isoformat")).all():
        return False
    # Separators of thousands are examined where the column is read.
    plain: Any = filled.astype(str).str.replace(r"[.,' \u2019\u00a0\u202f](?=\d{3})", "", regex=True)
    numbers: Any = pd.to_numeric(plain.str.replace(",", ".", regex=False), errors="coerce")
    return 2 * int(numbers.notna().sum()) > len(filled)  # a remark may be a number


def _clock(path: Path, file: Columns, time: str | None) -> TimeColumn:
    frame = file.values
    if time is not None and time not in frame:
        raise EstimationError(f"{path.name}: has no column {short(time)}; it has {known_names(frame, time)}")
    for name in [time] if time is not None else sorted(frame, key=_is_called_time, reverse=True):
        values = np.asarray(frame[name])
        text = file.units.get(name) or unit_in_brackets(name) or unit_at_end(name, "s")
        if values.dtype.kind not in "fiu" and not _is_numeric(values):
            if _is_called_time(name) or time is not None:
                return TimeColumn(column=name, unit="timestamp")
        elif time is not None or _is_called_time(name) or (text and _rises(values)):
            with suppress(UnitError):
                conversion(unit(text or ""), unit("s"))
                return TimeColumn(column=name, unit=text)
            if time is not None or _is_called_time(name):
                return TimeColumn(column=name)
    raise EstimationError(
        f"{path.name}: no column of time was recognised among {', '.join(frame)}; name it with --time COLUMN."
    )


def _rises(values: Any) -> bool:
    return bool((np.diff(np.asarray(pd.to_numeric(pd.Series(values), errors="coerce"), dtype=float)) >= 0.0).all())


def _is_called_time(name: str) -> bool:
    return _stem(name)[0] in ("time", *_NAMES["time"].split())


def _clock_line(clock: TimeColumn, path: Path) -> str:
    unit_of_time, remark = clock.unit, ""
    if unit_of_time is None:
        unit_of_time, remark = "s", f"  # {path.name} does not state it: seconds are assumed"
    keys = [f"column = {_toml(clock.column)}", f"unit = {_toml(unit_of_time)}"]
    keys += [] if clock.order is None else [f"order = {_toml(clock.order)}"]
    keys += [] if clock.repeats == "drop" else [f"repeats = {_toml(clock.repeats)}"]
    return f"time = {{ {', '.join(keys)} }}{remark}"


def _findings(name: str, series: Series) -> Iterator[ColumnMatch]:
    there = np.isfinite(series.values) & np.isfinite(series.time)
    time, values = series.time[there], series.values[there]
    steps = np.diff(time)
    if not (steps > 0.0).any():
        return
    period = float(np.median(steps[steps > 0.0]))
    yield ColumnMatch(
        name=name,
        unit=series.unit,
        samples=int(values.size),
        period=period,
        begin=float(time.min()),
        end=float(time.max()),
        low=float(values.min()),
        high=float(values.max()),
        gaps=tuple((float(time[i]), float(steps[i])) for i in np.flatnonzero(steps > _GAP * period)),
    )


def _gap_lines(inputs: Sequence[ColumnMatch], period: float) -> Iterator[str]:
    gaps = sorted(gap for finding in inputs for gap in finding.gaps)
    longest = max((length for _, length in gaps if length <= _BRIDGED), default=0.0)
    bridged = max(0.1, 5.0 * period, 1.01 * longest)
    yield f'longest_gap = "{1e3 * bridged:.6g} ms"  # inputs are interpolated over gaps up to this'
    cuts = [(begin, begin + length) for begin, length in gaps if length > _BRIDGED]
    if cuts:
        first, last = max(finding.begin for finding in inputs), min(finding.end for finding in inputs)
        begins, ends = [first, *accumulate((end for _, end in cuts), max)], [*(begin for begin, _ in cuts), last]
        begin, end = max(zip(begins, ends, strict=True), key=lambda part: part[1] - part[0])
        digits = max(0, math.ceil(-math.log10(period)) + 1)
        yield f'begin = "{begin:.{digits}f} s"  # inputs are missing before or after for more than {_BRIDGED:g} s'
        yield f'end = "{end:.{digits}f} s"'


def _resolution(findings: Iterable[ColumnMatch]) -> float:
    """Return the rounding of differences of the instants [s]: seconds since 1970 have some 1e-7."""
    return max(4.0 * float(np.spacing(max(abs(finding.begin), abs(finding.end)))) for finding in findings)


def _shortest(value: float, tolerance: float) -> float:
    """Return the number of fewest digits within a tolerance, six digits if none is."""
    candidates = (float(f"{value:.{digits}g}") for digits in range(1, 6))
    return next((each for each in candidates if abs(each - value) <= tolerance), float(f"{value:.6g}"))


def _with_unit(
    finding: ColumnMatch, recognised: Mapping[str, ColumnMatch], wanted: Mapping[str, _RequiredSignal]
) -> ColumnMatch:
    target = next((wanted[signal][0] for signal, other in recognised.items() if other is finding), "")
    return replace(finding, unit=(_unit_of(finding, target) if target else "") or finding.unit)


# ---- signals of the model -----------------------------------------------------------------------------------------


def _required_signals(specification: Specification) -> dict[str, _RequiredSignal]:
    units, inputs, outputs = signals_of(specification.model_copy(update={"data": None}))
    wanted: dict[str, _RequiredSignal] = {name: (units[name], name in inputs) for name in (*inputs, *outputs)}
    if specification.course is not None:
        wanted |= {name: (text, name != "braking") for name, text in UNITS_OF_RUN.items()}
        wanted |= {f"{ACCELERATION}[{i}]": ("m/s2", i == 1) for i in range(1, _MAX_ACCELEROMETERS + 1)}
        wanted["speed"] = "m/s", True
        wanted.pop("acceleration", None)  # the filter uses the mean of those along the track
    return wanted


def _recognise(findings: Sequence[ColumnMatch], wanted: Mapping[str, _RequiredSignal]) -> dict[str, ColumnMatch]:
    signals, stems = list(wanted), [_stem(finding.name) for finding in findings]
    from_zero = {stem for stem, number in stems if number == 0}
    places = [(stem, number if number is None else number + (stem in from_zero)) for stem, number in stems]
    scores = np.array(
        [
            [_score(name, wanted[name][0], *place, finding) for place, finding in zip(places, findings, strict=True)]
            for name in signals
        ]
    )
    pairs = zip(*linear_sum_assignment(scores, maximize=True), strict=True)
    return {signals[i]: findings[j] for i, j in pairs if scores[i, j] >= _LEAST}


def _score(signal: str, target: str, stem: str, number: int | None, finding: ColumnMatch) -> float:
    base, bracket = ElementName.of(signal)
    numbers = (ElementName.of(signal).place + 1,) if bracket else (None, 1)
    if number not in numbers or not _may_be(finding, target):
        return 0.0
    words = (base, *OTHER_NAMES.get(base, "").split(), *_NAMES.get(base, "").split())
    parts = set(stem.split("_"))
    if parts & _NOT_MEASURED and target != "1":  # whether the train drives or brakes may be recorded as a command
        return 0.0
    score = max(likeness(stem, words), *(0.9 for word in words if set(word.split("_")) <= parts), 0.0)
    return score if _unit_of(finding, target) else 0.95 * score


def _stem(name: str) -> tuple[str, int | None]:
    text = name_without_unit(re.sub(r" \(group \d+(, index \d+)?\)$", "", name))
    numbers = re.findall(r"\d+", text)
    return bare_name(re.sub(r"\d+", "_", text)), int(numbers[-1]) if numbers else None


def _may_be(finding: ColumnMatch, target: str) -> bool:
    if finding.unit is None:
        return True
    try:
        stated = unit(finding.unit)
    except UnitError:
        return True
    return stated.exponents == unit(target).exponents or _unit_of(finding, target) != ""


def _unit_of(finding: ColumnMatch, target: str) -> str:
    with suppress(UnitError):
        if finding.unit is not None:
            stated = unit(finding.unit)
            if time := turning_of(stated, unit(target)):
                return f"rev/{time}"
            conversion(stated, unit(target))
            return finding.unit
    return unit_at_end(finding.name, target) or ("1" if target == "1" else "")


def _columns(
    wanted: Mapping[str, _RequiredSignal], recognised: Mapping[str, ColumnMatch]
) -> tuple[list[str], list[str]]:
    lines: list[str] = []
    unrecognised: list[str] = []
    for signal, (unit_of_signal, is_needed) in wanted.items():
        key = _toml(signal) if "[" in signal else signal
        finding = recognised.get(signal)
        if finding is None:
            if is_needed:
                unrecognised.append(signal)
                instead = _FROM_ANOTHER.get(ElementName.of(signal).array, "")
                lines.append(
                    f'{key} = {{ column = "{_UNKNOWN}", unit = "{unit_of_signal}" }}  # needed, and not recognised; '
                    f'{instead}{{ value = "{_zero(unit_of_signal)}" }} where it is constant'
                )
            continue
        text, remark = _unit_of(finding, unit_of_signal), ""
        if not text and signal in _DEGREES:
            text, remark = "deg", "  # the file gives no unit: degrees are assumed"
        elif not text:
            unrecognised.append(signal)
            remark = f"  # the file gives no unit of the dimension of {unit_of_signal}"
        elif text.startswith("rev/") and finding.unit is not None and "rev" not in finding.unit:
            remark = f"  # the file says {finding.unit}: revolutions are assumed"
        rest = ", may_rest = true" if ElementName.of(signal).array in _MAY_REST else ""
        lines.append(f"{key} = {{ {_source(finding.name)}, unit = {_toml(text or _UNKNOWN)}{rest} }}{remark}")
    return lines, unrecognised


def _source(label: str) -> str:
    """Return the keys for a column, with group and index of a channel whose name occurs several times."""
    match = re.fullmatch(r"(.*) \(group (\d+)(?:, index (\d+))?\)", label)
    if match is None:
        return f"column = {_toml(label)}"
    name, group, index = match.groups()
    return f"column = {_toml(name)}, group = {group}" + (f", index = {index}" if index else "")


def _zero(unit_of_signal: str) -> str:
    return "0" if unit_of_signal == "1" else f"0 {unit_of_signal}"


def _toml(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
