"""Health over stops: index with uncertainty, trend, and an alarm of designed false-alarm rate.

The stops are those of a life or those in a folder; results are a figure and rows of a table.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.optimize import root_scalar

from railgrip.base.errors import EstimationError
from railgrip.base.records import inside
from railgrip.estimation.agreement import require_agreement
from railgrip.estimation.sources import complete_trace, recording_for
from railgrip.estimation.spec import Specification, parameters_for
from railgrip.estimators.belief import Matrix, Vector
from railgrip.recording.files import FORMATS
from railgrip.recording.samples import evenly
from railgrip.report import palette, style
from railgrip.report.table import ReportTable
from railgrip.studies.pad_monitor.evidence import MODEL, Evidence, evidence_of, formation
from railgrip.trace.recorder import FILE_NAME, read_trace

Kind = Literal["friction lost", "does not release"]

_UNKNOWN = 0.2
"""Standard deviation of unknown health: variation of lots and units, and faults to detect."""

_TOGETHER = 0.05
"""Common scatter of all groups before there are reference stops: the load of a train."""


FEWEST = 5
"""Minimum number of stops for a scatter."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MonitorDesign:
    """Design of the monitor.

    Attributes:
        reference: Number of stops after commissioning, with healthy brakes, with which later ones are compared.
        tolerated: Relative loss of friction of a group that still counts as healthy: glazing and wear.
        failed: Relative loss that must be detected.
        false_alarms: Design rate for each stop and group, at a loss of `tolerated`.
        minimum_scatter: Minimum relative scatter of friction from stop to stop.
        largest_deviation: Evidence with a larger standard deviation does not distinguish groups and is not charted.
        largest_step: Largest step of the chart, in standard deviations; a single outlier must not cause an alarm.
        drift: Random walk of health that the index follows [1/stop].
        drag: Increase of the coasting deceleration that indicates "does not release" [m/s²].
        trend: Number of stops for the trend.
    """

    reference: int = 20
    tolerated: float = 0.05
    failed: float = 0.20
    false_alarms: float = 1e-4
    minimum_scatter: float = 0.025
    largest_deviation: float = 0.08
    largest_step: float = 2.5
    drift: float = 0.004
    drag: float = 0.02
    trend: int = 40


@dataclass(frozen=True, slots=True, kw_only=True)
class Alarm:
    """An alarm for a group.

    Attributes:
        stop: Index of the stop that raised it, from 0.
        group: Index of the group, from 0.
        kind: Probable fault.
        loss: Relative loss of friction against the reference, mean over the stops since the chart left zero.
    """

    stop: int
    group: int
    kind: Kind
    loss: float


@dataclass(frozen=True, slots=True, kw_only=True)
class History:
    """Verdict of the monitor on a series of stops.

    Attributes:
        evidence: Health of each stop, shape (k, groups).
        deviation: Standard deviation of the evidence, shape (k, groups).
        index: Health filtered over stops, 1 nominal, shape (k, groups).
        index_sd: Standard deviation of the index, including offsets of pressure transducers, shape (k, groups).
        chart: Cumulated sum of each group, in deviations, shape (k, groups).
        threshold: Threshold of the chart, shape (groups,).
        trend: Slope of the index over the last stops [1/stop], shape (groups,).
        trend_sd: Standard deviation of the trend.
        alarms: Alarms in the order of stops.
        chart_points: Stops that distinguish the groups.
    """

    evidence: Matrix
    deviation: Matrix
    index: Matrix
    index_sd: Matrix
    chart: Matrix
    threshold: Vector
    trend: Vector
    trend_sd: Vector
    alarms: tuple[Alarm, ...]
    chart_points: int


def watch(stops: Sequence[Evidence], design: MonitorDesign) -> History:
    """Return the verdict of the monitor on stops, oldest first.

    Another load, wet pads and wind affect all groups equally; a fault affects one. Therefore the chart of a group is
    that of its health over the median of the others, relative to the same ratio in the reference stops. An equal loss
    of friction of all groups appears in the index, not in the chart.
    """
    count, groups = len(stops), len(stops[0].health) if stops else 0
    health = np.array([stop.health for stop in stops]).reshape(count, groups)
    deviation = np.array([stop.deviation for stop in stops]).reshape(count, groups)
    apart = np.asarray((deviation < design.largest_deviation).all(axis=1), dtype=np.bool_)
    reference = np.flatnonzero(apart)[: design.reference]
    # The common scatter of all groups (load, wet pads, wind) is that of the mean over groups.
    together = float(np.var(health[reference].mean(axis=1))) if reference.size > 2 else _TOGETHER**2
    ratio = np.full((count, groups), np.nan)
    for g in range(groups):
        others = [o for o in range(groups) if o != g]
        ratio[apart, g] = health[apart, g] / np.median(health[apart][:, others], axis=1)
    deficit, chart = np.full((count, groups), np.nan), np.zeros((count, groups))
    threshold = np.full(groups, np.nan)
    alarms: list[Alarm] = []
    if reference.size == design.reference:
        # Medians: an outlier in the reference must not reduce the sensitivity for the whole life.
        normal = np.median(ratio[reference], axis=0)
        deficit = 1.0 - ratio / normal
        mad = 1.4826 * np.median(np.abs(ratio[reference] / normal - 1.0), axis=0)
        scatter = np.maximum(mad, design.minimum_scatter)
        alarms, chart, threshold = _chart(stops, deficit, scatter, int(reference[-1]) + 1, design)
    index, index_sd = _follow(stops, together, _scatter_by_group(health[reference], design), alarms, design)
    trend, trend_sd = _trend(health, apart, design)
    return History(
        evidence=health,
        deviation=deviation,
        index=index,
        index_sd=index_sd,
        chart=chart,
        threshold=threshold,
        trend=trend,
        trend_sd=trend_sd,
        alarms=tuple(alarms),
        chart_points=int(apart.sum()),
    )


def threshold_for(scatter: float, design: MonitorDesign) -> float:
    """Return the threshold of the chart, in deviations, for the designed rate of false alarms.

    The mean number of stops between alarms of a chart with Gaussian steps of mean −δ is (exp(2δb) − 2δb − 1)/(2δ²),
    with b = h + 1.166. δ is the distance of the tolerated loss from the slack of the chart, which is the middle of
    tolerated and failed. The threshold is not below the sum of two of the largest steps, so that a single stop does not
    alarm.

    Source: Siegmund, Sequential Analysis (1985), for the cumulated sum of a shifted mean.
    """
    drift = 0.5 * (design.failed - design.tolerated) / scatter

    def excess(b: float) -> float:
        between = (math.expm1(2.0 * drift * b) - 2.0 * drift * b) / (2.0 * drift**2)
        return math.log(between * design.false_alarms)

    b = root_scalar(excess, bracket=(1e-3, 50.0 / drift)).root
    return max(float(b) - 1.166, 1.6 * design.largest_step)


def _chart(
    stops: Sequence[Evidence], deficit: Matrix, scatter: Vector, first: int, design: MonitorDesign
) -> tuple[list[Alarm], Matrix, Vector]:
    """Return the alarms, the chart from stop `first` on, and its threshold; an alarm of a group is its only one."""
    threshold, chart = np.array([threshold_for(float(s), design) for s in scatter]), np.zeros_like(deficit)
    slack = 0.5 * (design.tolerated + design.failed)
    before = [stop.drag for stop in stops[:first] if np.isfinite(stop.drag)]
    coasting = float(np.median(before)) if before else float("nan")
    alarms: list[Alarm] = []
    zero_until = np.full(len(threshold), first)
    distinct = np.zeros(len(threshold), dtype=np.bool_)
    for k in range(first, len(stops)):
        chart[k] = chart[k - 1]
        if np.isnan(deficit[k]).any():
            continue
        step = np.minimum((deficit[k] - slack) / scatter, design.largest_step)
        chart[k] = np.maximum(chart[k - 1] + step, 0.0)
        zero_until = np.where(chart[k] == 0.0, k + 1, zero_until)
        for g in np.flatnonzero((chart[k] > threshold) & ~distinct):
            since = slice(int(zero_until[g]), k + 1)
            drags = np.array([stop.drag for stop in stops[since]])
            sticks = bool(np.isfinite(drags).any() and np.nanmean(drags) - coasting > design.drag)
            kind: Kind = "does not release" if sticks else "friction lost"
            alarms.append(Alarm(stop=k, group=int(g), kind=kind, loss=float(np.nanmean(deficit[since, g]))))
            distinct[g] = True
    return alarms, chart, threshold


def _scatter_by_group(health: Matrix, design: MonitorDesign) -> Vector:
    # The covariance of the evidence covers noise only. Latencies and slides add scatter that only the stops themselves
    # reveal.
    if len(health) < FEWEST:
        return np.full(health.shape[1], design.minimum_scatter)
    apart = health - np.median(health, axis=1, keepdims=True)
    mad = 1.4826 * np.median(np.abs(apart - np.median(apart, axis=0)), axis=0)
    return np.maximum(mad, design.minimum_scatter)


def _follow(
    stops: Sequence[Evidence], together: float, residual: Vector, alarms: Sequence[Alarm], design: MonitorDesign
) -> tuple[Matrix, Matrix]:
    """Return health estimated by a Kalman filter over stops, with its standard deviation, each shape (k, groups).

    A transducer's offset is the same in every stop: it has no effect on the weight of a stop, and averaging does not
    remove it. `shift` is the change of the index due to offsets of one standard deviation, one per column, propagated
    through the same gains. Source: Schmidt, Application of State-Space Methods to Navigation Problems (1966).

    After an alarm the index of its group is reset, because health has jumped.

    Args:
        stops: Oldest first.
        together: Variance from stop to stop that all groups share.
        residual: Remaining standard deviation of each group from stop to stop, shape (groups,).
        alarms: Alarms of the chart.
        design: Design of the monitor.
    """
    groups = len(residual)
    mean, covariance = np.ones(groups), np.eye(groups) * _UNKNOWN**2
    shift = np.zeros((groups, groups))
    scatter = np.diag(residual**2) + together
    index, deviation = np.empty((len(stops), groups)), np.empty((len(stops), groups))
    for k, stop in enumerate(stops):
        jumps = np.array([any(alarm.stop == k and alarm.group == g for alarm in alarms) for g in range(groups)])
        covariance = covariance + np.diag(np.where(jumps, _UNKNOWN**2, design.drift**2))
        gain = np.linalg.solve(covariance + stop.covariance + scatter, covariance).T
        mean = mean + gain @ (stop.health - mean)
        remainder = np.eye(groups) - gain
        covariance = remainder @ covariance @ remainder.T + gain @ (stop.covariance + scatter) @ gain.T
        shift = remainder @ shift + gain * stop.offset
        index[k], deviation[k] = mean, np.sqrt(np.diag(covariance) + np.sum(shift**2, axis=1))
    return index, deviation


def _trend(health: Matrix, apart: NDArray[np.bool_], design: MonitorDesign) -> tuple[Vector, Vector]:
    """Return the slope of health over the last stops and its standard deviation [1/stop], each shape (groups,).

    The slope is a least-squares line through the stops that distinguish the groups; its deviation follows from their
    scatter about the line.
    """
    number = np.flatnonzero(apart)
    number = number[number >= len(health) - design.trend]
    if number.size < FEWEST:
        return np.full(health.shape[1], np.nan), np.full(health.shape[1], np.nan)
    time = number - number.mean()
    deviation = health[number] - health[number].mean(axis=0)
    slope = time @ deviation / (time @ time)
    scatter = np.sqrt(np.sum((deviation - np.outer(time, slope)) ** 2, axis=0) / (number.size - 2))
    return slope, scatter / np.sqrt(time @ time)


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
