"""Health over stops: index with uncertainty, trend, and an alarm of designed false-alarm rate."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root_scalar

from railgrip.estimators.belief import Matrix, Vector
from railgrip.studies.pad_monitor.evidence import Evidence

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
        threshold = np.array([threshold_for(float(s), design) for s in scatter])
        alarms = _chart(stops, deficit, scatter, threshold, int(reference[-1]) + 1, design, chart)
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
    stops: Sequence[Evidence],
    deficit: Matrix,
    scatter: Vector,
    threshold: Vector,
    first: int,
    design: MonitorDesign,
    chart: Matrix,
) -> list[Alarm]:
    # After an alarm the chart of that group is not updated.
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
    return alarms


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
