"""Errors of estimators by case, and their leaderboard."""

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Final

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.base.errors import FilterDiverged
from railgrip.base.names import ElementName
from railgrip.estimation.judge import NORMAL_95, rms
from railgrip.estimators.belief import Array, Vector
from railgrip.simulate.estimator import RELEASED_PADS
from railgrip.studies.estimators.available import TRUTH, AvailableErrors, available_errors, with_slip
from railgrip.studies.estimators.own import is_class, trace_with_class
from railgrip.studies.estimators.recordings import RecordingCase, recording_of_case
from railgrip.studies.estimators.replay import Replay, bound_of, columns, radii, replay, states, with_estimates
from railgrip.trace.estimation import SLOWEST, adhesion_errors, innovations
from railgrip.vehicle.signals import READINGS

TARGETS: Final[Mapping[str, str]] = {"adhesion": "group_adhesion", "pad_friction": "pad_friction", "speed": "speed"}
"""Estimated quantity → true variable of the trace."""

CONSTANT: Final = "constant"
"""Name of the best constant of the training set."""

FORCE_BALANCE: Final = "force_balance"

LOST: Final = 0.03
"""Error of adhesion above which an estimate is lost: the adhesion of a very slippery rail."""

IDENTIFIABLE: Final = 0.5
"""Bound of the variance of a pad friction over its first variance, up to which it is identifiable."""

STEP, STEP_TIME, LONGEST_DELAY = 0.02, 0.1, 0.5
"""A step of adhesion [1], the time in which it happens [s], and the longest delay after it [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseErrors:
    """Errors of an estimator in one recording above 10 km/h.

    Attributes:
        digest: SHA-256 of the readings, equal for all estimators.
        diverged: Whether the filter diverged; errors are NaN then.
        rmse: Target → root mean square error over all groups.
        bias: Mean error of adhesion over all groups.
        delay: Delay of adhesion, mean of the groups [s].
        step_delay: Median delay after a step of adhesion, see `step_delay` [s]; NaN without steps.
        lost: Share of samples in which the error of adhesion is above `LOST`.
        admitted: Share of these samples within the claimed 95 % interval; NaN without such samples or without a claim.
        coverage: Target → share of samples within the claimed 95 % interval; NaN without a claim.
        width: Median width of the claimed 95 % interval of adhesion.
        pads: Root mean square error of the pad friction of each group where identifiable; NaN without such samples.
        available: Errors of the available adhesion.
        nees: Mean squared error of adhesion over its variance, mean of the groups.
        nis: Median of the normalised innovation squared over its expected one; NaN without innovations.
        microseconds: Processor time of a step [µs].
    """

    digest: str
    diverged: bool
    rmse: Mapping[str, float]
    bias: float
    delay: float
    step_delay: float
    lost: float
    admitted: float
    coverage: Mapping[str, float]
    width: float
    pads: tuple[float, ...]
    available: AvailableErrors
    nees: float
    nis: float
    microseconds: float


EstimatorCase = tuple[RecordingCase, str, tuple[tuple[str, float], ...]]
"""A recording, the name of an estimator, and the best constants: target → value."""


def errors_of(case: EstimatorCase) -> CaseErrors:
    """Run an estimator over a recording and return its errors."""
    recording_case, estimator, constants = case
    if is_class(estimator):
        trace = trace_with_class(recording_case, estimator)
        return _judge(case, trace, _digest(trace), nis=innovations(trace)[0], microseconds=math.nan)
    recording = recording_of_case(recording_case)
    digest = _digest(recording)
    try:
        if estimator == CONSTANT:
            found = _constant(recording, states("", recording_case.train), dict(constants))
        else:
            found = replay(recording_case, estimator)
    except FilterDiverged:
        nothing = dict.fromkeys(TARGETS, math.nan)
        unknown: dict[str, Any] = dict.fromkeys((field.name for field in fields(CaseErrors)), math.nan)
        unknown.update(digest=digest, diverged=True, rmse=nothing, coverage=nothing)
        unknown.update(available=AvailableErrors(known=math.nan), pads=(math.nan,) * recording_case.groups)
        return CaseErrors(**unknown)
    names = states(estimator, recording_case.train)
    trace = with_estimates(recording, names, found.mean, found.variance)
    trace = _with_slip(trace, names, found, radii(estimator, recording_case.train))
    errors = _judge(case, trace, digest, nis=found.nis_ratio, microseconds=found.microseconds)
    return replace(errors, step_delay=math.nan) if estimator == CONSTANT else errors


def _with_slip(trace: xarray.Dataset, names: Sequence[str], found: Replay, radius: Vector) -> xarray.Dataset:
    """Return the recording with the slip of estimated speeds."""
    (speed,), wheels = columns(names, "speed"), columns(names, "wheelset_speed")
    deviation = np.sqrt(found.variance)
    return with_slip(
        trace, found.mean[:, speed], found.mean[:, wheels], (deviation[:, speed], deviation[:, wheels]), radius
    )


def _digest(trace: xarray.Dataset) -> str:
    """Return the SHA-256 of the readings."""
    return hashlib.sha256(b"".join(trace[signal.name].values.tobytes() for signal in READINGS)).hexdigest()


def _constant(recording: xarray.Dataset, names: Sequence[str], constants: Mapping[str, float]) -> Replay:
    bases = {"group_adhesion": "adhesion", "pad_friction": "pad_friction"}
    row = [constants.get(bases.get(ElementName.of(name).array, ""), math.nan) for name in names]
    mean = np.tile(row, (recording.sizes["time"], 1))
    return Replay(mean=mean, variance=np.full(mean.shape, math.nan), nis_ratio=None, microseconds=0.0)


def _judge(
    case: EstimatorCase, trace: xarray.Dataset, digest: str, nis: float | None, microseconds: float
) -> CaseErrors:
    adhesion = adhesion_errors(trace)
    errors = {target: errors_of_target(trace, target) for target in TARGETS}
    error, deviation = errors["adhesion"]
    is_lost = np.abs(error) > LOST
    return CaseErrors(
        digest=digest,
        diverged=False,
        rmse={target: rms(error) if error.size else math.nan for target, (error, _) in errors.items()},
        bias=_mean(adhesion["adhesion_bias"]),
        delay=_mean(adhesion["adhesion_delay"]),
        step_delay=step_delay(trace),
        lost=float(np.mean(is_lost)) if error.size else math.nan,
        admitted=_coverage(error[is_lost], deviation[is_lost]),
        coverage={target: _coverage(*pair) for target, pair in errors.items()},
        width=2.0 * NORMAL_95 * float(np.median(deviation)) if deviation.size else math.nan,
        pads=_errors_of_groups(trace, case[0]),
        available=available_errors(trace, dict(case[2]).get("available", math.nan), NORMAL_95),
        nees=_mean(adhesion["adhesion_nees"]),
        nis=math.nan if nis is None else nis,
        microseconds=microseconds,
    )


def _coverage(error: Array, deviation: Array) -> float:
    is_claimed = deviation.size > 0 and bool(np.isfinite(deviation).all())
    return float(np.mean(np.abs(error) <= NORMAL_95 * deviation)) if is_claimed else math.nan


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


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseBound:
    """Posterior Cramér-Rao bound of a recording.

    Attributes:
        adhesion: Root mean square of the bound of adhesion over groups and time.
        identifiable: Share of the samples with pressing pads above 10 km/h in which the pad friction of each group is
            identifiable; NaN without such samples.
    """

    adhesion: float
    identifiable: tuple[float, ...]


def bounds_of(case: RecordingCase) -> CaseBound:
    """Return the bound of a recording."""
    recording, adhesions = recording_of_case(case), columns(states("", case.train), "group_adhesion")
    columns_of_groups = zip(pads_are_identifiable(case).T, _pads_press(recording).T, strict=True)
    return CaseBound(
        adhesion=float(np.sqrt(np.mean(bound_of(case)[:, adhesions]))),
        identifiable=tuple(
            float(np.mean(known[judged])) if judged.any() else math.nan for known, judged in columns_of_groups
        ),
    )


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
