"""Errors of estimators by case: of adhesion used and available, pad friction and speed, and bounds of them.

Errors of the adhesion available are those where the slope of the creep curve determines it. The search of noises uses
the same errors: one coordinate search on training cases, with the same budget for every estimator.
"""

import hashlib
import math
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Final

import numpy as np
import xarray
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from railgrip.base.errors import FilterDiverged
from railgrip.base.files import write_text
from railgrip.base.names import ElementName
from railgrip.base.tables import JsonObject
from railgrip.estimation.judgement import NORMAL_95, rms
from railgrip.estimation.run import FilterRun
from railgrip.estimators.belief import Array, Matrix, Vector
from railgrip.estimators.rail import estimate_slope
from railgrip.simulate.estimator import RELEASED_PADS
from railgrip.studies.estimators.recordings import (
    PERIOD,
    SENSORS,
    RecordingCase,
    Sensors,
    is_class,
    recording_of_case,
    trace_with_class,
)
from railgrip.studies.estimators.replay import (
    CONSTANT,
    FACTORS,
    SEARCHED,
    bound_of,
    columns,
    noise_of,
    replay,
    states,
    with_estimates,
)
from railgrip.trace.measures import SLOWEST, adhesion_errors, innovations
from railgrip.vehicle.signals import READINGS

TRUTH: Final = "peak_adhesion"
"""Variable of the recordings: maximum of the creep curve of a group at its place and instant."""

RECENT: Final = 1.0
"""Time over which the reference takes the largest adhesion [s]."""


def available_errors(trace: xarray.Dataset, constant: float, quantile: float) -> dict[str, float]:
    """Return the errors of the available adhesion in a recording with estimates of adhesion and slip, over all groups.

    `known` is the share of samples above 10 km/h in which the estimator knows it; NaN without estimates of adhesion and
    slip. All others are of these samples, NaN without any: `rmse` and `bias`; `coverage`, the share of samples within
    the claimed 95 % interval of adhesion, NaN without a claim; `recent`, the root mean square error of the largest
    estimated adhesion of the last `RECENT`; `constant`, that of the best constant.

    Args:
        trace: The recording.
        constant: Mean of the available adhesion in the training set.
        quantile: Half of the claimed interval, in standard deviations.
    """
    errors: dict[str, float] = dict.fromkeys(("known", "rmse", "bias", "coverage", "recent", "constant"), math.nan)
    if "estimate_slip" not in trace or "estimate_adhesion" not in trace:
        return errors
    moving = trace["speed"].values > SLOWEST
    adhesion, slip, truth = (trace[name].values[moving] for name in ("estimate_adhesion", "estimate_slip", TRUTH))
    deviation, slip_deviation = (
        trace[name].values[moving] if name in trace else np.full(slip.shape, math.nan)
        for name in ("estimate_adhesion_sd", "estimate_slip_sd")
    )
    if not np.isfinite(slip).any():
        return errors
    columns = zip(adhesion.T, slip.T, np.nan_to_num(slip_deviation).T, strict=True)
    found = np.stack([estimate_slope(a, s, PERIOD, slip_deviation=sd).available for a, s, sd in columns], axis=1)
    is_known = np.isfinite(found)
    errors["known"] = float(np.mean(is_known))
    if not is_known.any():
        return errors
    error, claimed = (found - truth)[is_known], deviation[is_known]
    recent = largest_of_last(adhesion, round(RECENT / PERIOD))
    return errors | {
        "rmse": rms(error),
        "bias": float(np.mean(error)),
        "coverage": coverage(error, claimed, quantile),
        "recent": rms((recent - truth)[is_known]),
        "constant": rms((constant - truth)[is_known]),
    }


def coverage(error: Array, deviation: Array, quantile: float) -> float:
    """Return the share of errors within `quantile` claimed deviations; NaN without errors or without a claim."""
    is_claimed = deviation.size > 0 and bool(np.isfinite(deviation).all())
    return float(np.mean(np.abs(error) <= quantile * deviation)) if is_claimed else math.nan


def largest_of_last(values: Matrix, count: int) -> Matrix:
    """Return the largest of the last `count` rows at each row, shape as `values`."""
    return maximum_filter1d(values, count, axis=0, mode="nearest", origin=(count - 1) // 2)


TARGETS: Final[Mapping[str, str]] = {"adhesion": "group_adhesion", "pad_friction": "pad_friction", "speed": "speed"}
"""Estimated quantity → true variable of the trace."""

LOST: Final = 0.03
"""Error of adhesion above which an estimate is lost: the adhesion of a very slippery rail."""

IDENTIFIABLE: Final = 0.5
"""Bound of the variance of a pad friction over its first variance, up to which it is identifiable."""

STEP, STEP_TIME, LONGEST_DELAY = 0.02, 0.1, 0.5
"""A step of adhesion [1], the time in which it happens [s], and the longest delay after it [s]."""


EstimatorCase = tuple[RecordingCase, str, tuple[tuple[str, float], ...]]
"""A recording, the name of an estimator, and the best constants: target → value."""


def errors_of(case: EstimatorCase) -> JsonObject:
    """Run an estimator over a recording and return its errors above 10 km/h by name; NaN if they do not exist.

    After a divergence there are only `digest`, `diverged` and `pads`, which is NaN.

    Returns:
        digest: SHA-256 of the readings, equal for all estimators.
        diverged: Whether the filter diverged.
        rmse: Target → root mean square error over all groups.
        bias: Of adhesion, mean of the groups, as `delay` and `nees`.
        delay: Delay of adhesion [s].
        step_delay: See `step_delay` [s].
        lost: Share of samples in which the error of adhesion is above `LOST`.
        admitted: Share of these within the claimed 95 % interval.
        coverage: Target → share of all samples within the claimed 95 % interval.
        width: Median width of that of adhesion.
        pads: Root mean square error of the pad friction of each group where identifiable.
        available: See `available_errors`.
        nees: Normalised estimation error squared.
        nis: Median of the normalised innovation squared over its expected one.
        microseconds: Processor time of a step [µs].
    """
    recording_case, estimator, constants = case
    if is_class(estimator):
        trace = trace_with_class(recording_case, estimator)
        return _judge(case, trace, nis=innovations(trace).get("nis_ratio"), microseconds=math.nan)
    try:
        run = _constant(recording_case, dict(constants)) if estimator == CONSTANT else replay(recording_case, estimator)
    except FilterDiverged:
        digest = _digest(recording_of_case(recording_case))
        return {"digest": digest, "diverged": True, "pads": (math.nan,) * recording_case.groups}
    trace = with_estimates(recording_case, estimator, run)
    errors = _judge(case, trace, nis=run.nis_ratio, microseconds=run.microseconds)
    return errors | {"step_delay": math.nan} if estimator == CONSTANT else errors


def _digest(trace: xarray.Dataset) -> str:
    """Return the SHA-256 of the readings."""
    return hashlib.sha256(b"".join(trace[signal.name].values.tobytes() for signal in READINGS)).hexdigest()


def _constant(case: RecordingCase, constants: Mapping[str, float]) -> FilterRun:
    bases = {"group_adhesion": "adhesion", "pad_friction": "pad_friction"}
    row = [constants.get(bases.get(ElementName.of(name).array, ""), math.nan) for name in states(CONSTANT, case.train)]
    mean = np.tile(row, (recording_of_case(case).sizes["time"], 1))
    return FilterRun(mean=mean, variance=np.full(mean.shape, math.nan))


def _judge(case: EstimatorCase, trace: xarray.Dataset, nis: float | None, microseconds: float) -> JsonObject:
    adhesion = adhesion_errors(trace)
    errors = {target: errors_of_target(trace, target) for target in TARGETS}
    error, deviation = errors["adhesion"]
    is_lost = np.abs(error) > LOST
    return {
        "digest": _digest(trace),
        "diverged": False,
        "rmse": {target: rms(error) if error.size else math.nan for target, (error, _) in errors.items()},
        "bias": _mean(adhesion.get("adhesion_bias")),
        "delay": _mean(adhesion.get("adhesion_delay")),
        "step_delay": step_delay(trace),
        "lost": float(np.mean(is_lost)) if error.size else math.nan,
        "admitted": coverage(error[is_lost], deviation[is_lost], NORMAL_95),
        "coverage": {target: coverage(*pair, NORMAL_95) for target, pair in errors.items()},
        "width": 2.0 * NORMAL_95 * float(np.median(deviation)) if deviation.size else math.nan,
        "pads": _errors_of_groups(trace, case[0]),
        "available": available_errors(trace, dict(case[2]).get("available", math.nan), NORMAL_95),
        "nees": _mean(adhesion.get("adhesion_nees")),
        "nis": math.nan if nis is None else nis,
        "microseconds": microseconds,
    }


def step_delay(trace: xarray.Dataset) -> float:
    """Return the median time by which the estimate passes the middle of a step of adhesion after the truth [s].

    A step is a change of the true adhesion of a group by `STEP` within `STEP_TIME`. An estimate that does not pass the
    middle within `LONGEST_DELAY` counts as that long. NaN without steps or without an estimate.
    """
    if "estimate_adhesion" not in trace:
        return math.nan
    period = float(trace["time"].values[1] - trace["time"].values[0])
    width, longest = round(STEP_TIME / period), round(LONGEST_DELAY / period)
    delays: list[int] = []
    for truth, estimate in zip(
        _moving(trace, TARGETS["adhesion"]).T, _moving(trace, "estimate_adhesion").T, strict=True
    ):
        k = 0
        while k + width + longest < len(truth):
            change = truth[k + width] - truth[k]
            if abs(change) < STEP:
                k += 1
                continue
            middle = 0.5 * (truth[k + width] + truth[k])
            first, second = (
                int(np.argmax(np.append((values[k : k + longest] - middle) * change >= 0.0, True)))
                for values in (truth, estimate)
            )
            delays.append(second - first)
            k += longest
    return float(np.median(delays)) * period if delays else math.nan


def _mean(values: tuple[float, ...] | None) -> float:
    return math.nan if values is None else float(np.mean(values))


def _moving(trace: xarray.Dataset, name: str) -> Array:
    return trace[name].values[trace["speed"].values > SLOWEST]


def errors_of_target(trace: xarray.Dataset, target: str) -> tuple[Array, Array]:
    """Return error and claimed deviation of all groups above 10 km/h; of pad friction only while the pads press.

    Both are empty without an estimate; the deviation is NaN if the estimator claims none.
    """
    if f"estimate_{target}" not in trace:
        return np.empty(0), np.empty(0)
    error = _moving(trace, f"estimate_{target}") - _moving(trace, TARGETS[target])
    claimed = f"estimate_{target}_sd"
    deviation = _moving(trace, claimed) if claimed in trace else np.full(error.shape, math.nan)
    if target != "pad_friction":
        return error.ravel(), deviation.ravel()
    presses = _moving(trace, "pad_force") > RELEASED_PADS
    return error[presses], deviation[presses]


def truths_of(case: RecordingCase) -> dict[str, tuple[float, int]]:
    """Return sum and number of the true values of adhesion used and available and of pad friction that are judged."""
    recording = recording_of_case(case)
    values = {
        "adhesion": _moving(recording, TARGETS["adhesion"]),
        "pad_friction": _moving(recording, "pad_friction")[_moving(recording, "pad_force") > RELEASED_PADS],
        "available": _moving(recording, TRUTH),
    }
    return {target: (float(np.sum(each)), each.size) for target, each in values.items()}


CaseBound = tuple[float, tuple[float, ...]]
"""Posterior Cramér-Rao bound of a recording: root mean square of that of adhesion over groups and time; and the share
of the samples with pressing pads above 10 km/h in which the pad friction of each group is identifiable, NaN without
such samples."""


def bounds_of(case: RecordingCase) -> CaseBound:
    """Return the bound of a recording."""
    recording, adhesions = recording_of_case(case), columns(states("", case.train), "group_adhesion")
    columns_of_groups = zip(pads_are_identifiable(case).T, _pads_press(recording).T, strict=True)
    identifiable = (float(np.mean(known[judged])) if judged.any() else math.nan for known, judged in columns_of_groups)
    return float(np.sqrt(np.mean(bound_of(case)[:, adhesions]))), tuple(identifiable)


def pads_are_identifiable(case: RecordingCase) -> NDArray[np.bool_]:
    """Return at each sample whether the pad friction of a group is identifiable, shape (k, groups).

    That is where its bound is not above `IDENTIFIABLE` of the first variance. Then readings have as much information on
    it as the first belief.
    """
    bound = bound_of(case)[:, columns(states("", case.train), "pad_friction")]
    return bound <= IDENTIFIABLE * bound[0]


def _pads_press(trace: xarray.Dataset) -> NDArray[np.bool_]:
    moving = trace["speed"].values[:, np.newaxis] > SLOWEST
    return moving & (trace["pad_force"].values > RELEASED_PADS)


def _errors_of_groups(trace: xarray.Dataset, case: RecordingCase) -> tuple[float, ...]:
    """Return the root mean square error of the pad friction of each group where identifiable, NaN elsewhere."""
    judged = pads_are_identifiable(case) & _pads_press(trace)
    if "estimate_pad_friction" not in trace:
        return (math.nan,) * judged.shape[1]
    error = (trace["estimate_pad_friction"] - trace["pad_friction"]).values
    return tuple(rms(each[where]) if where.any() else math.nan for each, where in zip(error.T, judged.T, strict=True))


BUDGET: Final = 48
"""Evaluations of an estimator for a class of sensors, each over all of its training cases."""

STEPS: Final = (3.0, 3.0, math.sqrt(3.0), math.sqrt(3.0))
"""Factors by which standard deviations change, one after the other in each pass."""

SMALLEST_GAIN: Final = 1e-3
"""Gain of `evaluate` that justifies a change: a tenth of a percent of an interval."""

SearchCase = tuple[str, Sensors, tuple[RecordingCase, ...]]
"""An estimator, a class of sensors, and training cases with these sensors."""


def interval_score(error: Vector, deviation: Vector) -> float:
    """Return the mean interval score of the claimed 95 % interval: its width plus 40 times the excess beyond it.

    It is smallest for the true quantiles, and an outlier counts linearly.

    Source: Gneiting and Raftery, Strictly Proper Scoring Rules, J. American Statistical Association 102 (2007) 359,
    eq. 43.
    """
    half = NORMAL_95 * deviation
    return float(np.mean(2.0 * half + 40.0 * np.maximum(np.abs(error) - half, 0.0)))


def evaluate(estimator: str, sensors: Sensors, cases: Sequence[RecordingCase], factors: Mapping[str, float]) -> float:
    """Return the mean over cases of the logarithms of the interval scores of adhesion and pad friction."""
    noise, total = noise_of(estimator, sensors, factors), 0.0
    for case in cases:
        try:
            trace = with_estimates(case, estimator, replay(case, estimator, noise))
        except FilterDiverged:
            return math.inf
        for target in ("adhesion", "pad_friction"):
            error, deviation = errors_of_target(trace, target)
            total += math.log(interval_score(error, deviation)) if error.size else 0.0
    return total / len(cases)


def search(case: SearchCase) -> dict[str, float]:
    """Return the factors that minimise `evaluate`: each in turn up or down by a step, as long as the budget lasts.

    A factor without any effect is tried once.
    """
    estimator, sensors, cases = case
    factors: dict[str, float] = dict.fromkeys(FACTORS, 1.0)
    best, count, idle = evaluate(estimator, sensors, cases, factors), 1, set[str]()
    for step, name in product(STEPS, FACTORS):
        for change in () if name in idle else (step, 1.0 / step):
            if count >= BUDGET:
                return factors
            trial = factors | {name: factors[name] * change}
            value, count = evaluate(estimator, sensors, cases, trial), count + 1
            if value == best:
                idle.add(name)
                break
            if value < best - SMALLEST_GAIN:
                factors, best = trial, value
                break
    return factors


def search_cases(cases: Sequence[RecordingCase], estimators: Sequence[str] = SEARCHED) -> list[SearchCase]:
    """Return one search for each estimator and class of sensors."""
    return [
        (estimator, sensors, tuple(case for case in cases if case.sensors == sensors))
        for estimator in estimators
        for sensors in SENSORS
    ]


def write_factors(path: Path, found: Mapping[tuple[str, str], Mapping[str, float]]) -> None:
    """Write factors by estimator and sensors as a file that `read_factors` reads."""
    lines = ["# Factors of standard deviations; written by `railgrip study estimators --tune`."]
    for (estimator, sensors), factors in found.items():
        values = ", ".join(f"{name} = {value:.4g}" for name, value in factors.items())
        lines += ["", f"[{estimator}]"] if f"[{estimator}]" not in lines else []
        lines.append(f"{sensors} = {{ {values} }}")
    write_text(path, "\n".join(lines) + "\n")
