"""The monitor over the stops in a folder: their evidence, and the results as a figure and as rows of a table."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from railgrip.base.errors import EstimationError
from railgrip.base.records import inside
from railgrip.estimation.agreement import require_agreement
from railgrip.estimation.sources import complete_trace, recording_for
from railgrip.estimation.spec import Specification, parameters_for
from railgrip.recording.files import FORMATS
from railgrip.recording.samples import evenly
from railgrip.report import palette, style
from railgrip.report.table import ReportTable
from railgrip.studies.pad_monitor.evidence import MODEL, Evidence, evidence_of, formation
from railgrip.studies.pad_monitor.watch import History, MonitorDesign
from railgrip.trace.recorder import FILE_NAME, read_trace

TEMPERATURE = "reading_disc_temperature"
"""Variable (time, group) of a trace with the temperature of the discs [K]; its first sample is used."""

UNKNOWN_TEMPERATURE = 313.15
"""Assumed temperature of the discs at the first sample where it is not given, as in the plant: 40 °C."""


def stops_in(
    folder: Path,
    specification: Specification | None = None,
    progress: Callable[[int, int], None] = lambda count, of: None,
) -> tuple[dict[str, Evidence], list[str]]:
    """Return the evidence of all stops in a folder, by name and in order, and remarks on omissions, corrections and
    assumptions.

    A stop is a folder with a trace.nc in it, or, with a specification that maps their columns, a recorded file. Stops
    that cannot be used are omitted with a remark.

    Raises:
        EstimationError: The folder has no stops.
    """
    if not folder.is_dir():
        raise EstimationError(f"{folder}: there is no such folder; name one that holds stops.")
    if specification is None:
        places = sorted(path.parent for path in folder.glob(f"*/{FILE_NAME}"))
    else:
        if specification.model.class_ != MODEL:
            raise EstimationError(
                f"{specification.name}: [model] class is '{specification.model.class_}', the monitor needs '{MODEL}'."
            )
        places = sorted(path for path in folder.iterdir() if path.suffix.lower() in FORMATS)
    parameters = {} if specification is None else parameters_for(specification)
    if not places:
        what = f"*/{FILE_NAME}" if specification is None else ", ".join(f"*{suffix}" for suffix in FORMATS)
        hint = "; for recorded files give their map, --map FILE.toml" if specification is None else ""
        raise EstimationError(f"{folder}: there are no stops ({what}) in it{hint}.")
    evidence: dict[str, Evidence] = {}
    sentences: list[str] = []
    assumptions = 0
    for number, place in enumerate(places):
        progress(number, len(places))
        try:
            temperature = np.full(formation().groups, UNKNOWN_TEMPERATURE)
            if specification is None:
                trace = read_trace(inside(folder, f"{place.name}/{FILE_NAME}"))
                recording = evenly(trace, place.name)
                if TEMPERATURE in trace:
                    temperature = trace[TEMPERATURE].values[0]
                else:
                    assumptions += 1
            else:
                recording = recording_for(specification, place).recording
                sentences += [f"{place.name}: {sentence}" for sentence in recording.attrs["flags"]]
                run = complete_trace(specification, recording)
                sentences += require_agreement(specification, run, run, place.name)
                assumptions += 1
            evidence[place.name] = evidence_of(recording, temperature, parameters)
        except EstimationError as problem:
            sentences.append(f"{place.name}: left out: {problem}")
    if assumptions:
        sentences.append(
            f"{assumptions} stops do not have the temperature of their discs; {UNKNOWN_TEMPERATURE - 273.15:.0f} °C is "
            "assumed at their beginning, 0.7 ‰ of friction a kelvin."
        )
    return evidence, sentences


def group_names() -> list[str]:
    """Return the names of the groups, by their wheelsets, counted from the leading one."""
    return [
        f"wheelset {members.stop}"
        if members.stop - members.start == 1
        else f"wheelsets {members.start + 1} to {members.stop}"
        for members in formation().members()
    ]


def health_table(history: History, names: Sequence[str]) -> ReportTable:
    """Return one row for each group: index, trend, alarm."""
    alarms = {alarm.group: alarm for alarm in reversed(history.alarms)}
    rows = [
        {
            "group": f"{g + 1} {name}",
            "health": f"{history.index[-1, g]:.3f} ± {history.index_sd[-1, g]:.3f}",
            "trend per 100 stops": f"{1e4 * history.trend[g]:+.1f} % ± {1e4 * history.trend_sd[g]:.1f} %"
            if np.isfinite(history.trend_sd[g])
            else "too few stops",
            "alarm": f"{alarm.kind} by {names[alarm.stop]}, {100 * alarm.loss:.0f} % below its reference"
            if (alarm := alarms.get(g))
            else "none",
        }
        for g, name in enumerate(group_names())
    ]
    return ReportTable(rows, left=rows[0])


def summary_of(history: History, design: MonitorDesign) -> str:
    """Return a sentence on the evidence of the stops, and on further evidence that is needed."""
    count = len(history.index)
    opening = f"Stops that distinguish the groups: {history.chart_points} of {count}"
    if history.chart_points == 0:
        return (
            f"{opening}; the pressures never differed enough, so that only the brakes as a whole are judged; make "
            "testing stops that release one group after the other for two seconds, or stops with wheel-slide "
            "protection at work."
        )
    if history.chart_points <= design.reference:
        return f"{opening}; alarms need more than {design.reference}, the reference."
    return f"{opening}; the first {design.reference} of those are the reference."


def draw(history: History, design: MonitorDesign) -> Figure:
    """Draw health and chart of each group over the stops."""
    called = group_names()
    drawing, axes = style.panels(11.0, 2.0 * len(called), len(called), 2, sharex=True, width_ratios=(3, 2))
    number = np.arange(len(history.index)) + 1
    for g, name in enumerate(called):
        left, right = axes[g]
        distinct = history.deviation[:, g] < design.largest_deviation
        left.plot(
            number[distinct], history.evidence[distinct, g], ".", color=palette.GREY, markersize=3, label="one stop"
        )
        left.plot(number, history.index[:, g], color=palette.BLUE, label="index")
        reach = 2.0 * history.index_sd[:, g]
        style.band(left, number, history.index[:, g] - reach, history.index[:, g] + reach, palette.BLUE, 0.2)
        right.plot(number, history.chart[:, g], color=palette.BLUE)
        right.axhline(history.threshold[g], color=palette.VERMILION, lw=1.0, label="threshold")
        for alarm in history.alarms:
            if alarm.group == g:
                for part in (left, right):
                    part.axvline(alarm.stop + 1, color=palette.VERMILION, lw=1.0, ls="--")
                left.annotate(alarm.kind, (alarm.stop + 1, 0.36), color=palette.VERMILION, fontsize=8, ha="right")
        left.set_ylim(0.3, 1.4)
        # The chart continues after an alarm; only its course before the alarm is relevant.
        right.set_ylim(0.0, 2.5 * history.threshold[g] if np.isfinite(history.threshold[g]) else 1.0)
        style.dress(left, y="friction over nominal", title=f"group {g + 1}: {name}")
        style.dress(right, y="cumulated sum [σ]")
    style.legend(axes[0, 0], loc="upper right", ncols=2)
    for part in axes[-1]:
        part.set_xlabel("stop")
    return drawing
