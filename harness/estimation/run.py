"""Run filters over a recording: mean and standard deviation of every state, and innovations, at every sample.

Filters start from a released brake, so with adhesion and deflections of zero. Where the recording begins inside a
braking, the balance of each wheelset and frame determines both:

    dω/dt (α, z, μ_b, u) = slope of the wheelset speed,    d²z/dt² (α, z, μ_b, u) = 0

Their covariance follows from that of the pad friction, to first order, and from the deviations of [start].
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from time import process_time
from typing import Literal

import numpy as np
import xarray
from numpy.typing import NDArray
from scipy.ndimage import binary_closing

from railgrip.base import registry
from railgrip.base.errors import EstimationError, FilterDiverged
from railgrip.base.names import ElementName, did_you_mean, state_name
from railgrip.estimation.models import READ_STATES
from railgrip.estimators.belief import GaussianEstimate, Matrix, Vector
from railgrip.estimators.compiled import CompiledFilter, FilterRecord
from railgrip.estimators.consistency import FAR, loss_step, nis_ratio
from railgrip.estimators.design import FilterContext, FilterKind, Gate
from railgrip.estimators.prediction import Prediction, PredictionInC
from railgrip.recording.faults import intervals
from railgrip.recording.samples import period_of, samples

STANDSTILL = 1.0
"""Speed below which rejected readings are not reported [m/s]."""
REJECTED_TOGETHER = 0.5
"""Longest time between rejected samples of one sentence [s]."""
MOST_REJECTIONS = 3
"""Number of sentences for each reading."""
LONGEST_STEP = 1.5
"""Product of period and fastest mode of a model beyond which a filter takes several steps from sample to sample.

Classical Runge-Kutta is stable up to 2.8; see `railgrip.estimators.belief`.
"""
FINE_STEP = 0.6
"""Largest such product of each of several steps: one step then has an error of 0.6^5/120, below 0.1 %, in that mode."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Settings of a filter besides its model.

    A name without index refers to all elements of an array; a name with index (`wheelset_speed[2]`) takes precedence
    over it.

    Attributes:
        process: Density of the noise of each state, (unit of the state)²/s.
        readings: Variance of each reading.
        start: Mean of each state at the first sample; those in `READ_STATES` may be left out.
        start_deviation: Standard deviation of each state at the first sample.
        steady: Whether a recording that begins inside a braking starts as `start_in_braking` does.
        gate: States to hold constant, with the condition, or None.
        outlier_limit: Number of standard deviations beyond which readings are rejected; None uses all.
        between: Inputs between two samples: `held` at the earlier one, for commands of a digital controller, or the
            `mean` of both, for measured inputs that vary continuously.
    """

    process: Mapping[str, float]
    readings: Mapping[str, float]
    start: Mapping[str, float]
    start_deviation: Mapping[str, float]
    steady: bool = False
    gate: Gate | None = None
    outlier_limit: float | None = None
    between: Literal["held", "mean"] = "held"


def start_by_reading(states: Sequence[str], outputs: Sequence[str]) -> dict[str, str]:
    """Return state → reading for the states that may be initialised with their first reading."""
    return {state: state for state in states if ElementName.of(state).array in READ_STATES and state in outputs}


@dataclass(frozen=True, slots=True, kw_only=True)
class FilterData:
    """A recording as the arrays of a filter, for k samples after the first.

    Attributes:
        inputs: Inputs over each step of the filter, shape (k steps, inputs).
        readings: Readings at each sample, NaN where missing, shape (k, outputs).
        mean, covariance: Estimate at the first sample, shapes (states,) and (states, states).
        period: Time between samples [s].
        steps: Steps of the filter from sample to sample; more than one if the model is too fast for the period.
    """

    inputs: Matrix
    readings: Matrix
    mean: Vector
    covariance: Matrix
    period: float
    steps: int = 1

    @property
    def step(self) -> float:
        """Time of a step of the filter [s]."""
        return self.period / self.steps

    @property
    def readings_by_step(self) -> Matrix:
        """Readings at each step of the filter, NaN between samples, shape (k steps, outputs)."""
        if self.steps == 1:
            return self.readings
        rows = np.full((len(self.readings) * self.steps, self.readings.shape[1]), np.nan)
        rows[self.steps - 1 :: self.steps] = self.readings
        return rows


def filter_data(
    recording: xarray.Dataset, prediction: PredictionInC, settings: Settings, units: Mapping[str, str] | None = None
) -> FilterData:
    """Return a recording as the arrays of a filter; arguments and errors as for `estimate`."""
    outputs, unit_of_name = prediction.outputs, dict(units or {})
    readings = samples(recording, outputs, [unit_of_name.get(name) for name in outputs])
    inputs, period = _inputs(recording, prediction, unit_of_name), period_of(recording)
    deviation = by_name("[start] deviation", settings.start_deviation, prediction.states)
    mean, covariance = _start(settings.start, prediction.states, outputs, readings), np.diag(deviation**2)
    if settings.steady:
        mean, covariance = start_in_braking(prediction, mean, deviation, inputs[0], readings, period)
    steps = steps_per_sample(prediction, mean, inputs, period)
    return FilterData(
        inputs=_by_step(inputs, steps, settings.between),
        readings=readings[1:],
        mean=mean,
        covariance=covariance,
        period=period,
        steps=steps,
    )


def steps_per_sample(prediction: PredictionInC, mean: Vector, inputs: Matrix, period: float) -> int:
    """Return the number of steps that a filter takes from sample to sample; see `LONGEST_STEP`.

    Args:
        prediction: The model.
        mean: States at the first sample, shape (states,).
        inputs: Shape (k, inputs); the fastest mode is that of their first and largest values.
        period: Time between samples [s].
    """
    modes = [np.abs(np.linalg.eigvals(prediction.derivative_jacobian(mean, row))) for row in (inputs[0], inputs.max(0))]
    fastest = max((float(np.max(each, initial=0.0)) for each in modes if np.isfinite(each).all()), default=0.0)
    return 1 if fastest * period <= LONGEST_STEP else math.ceil(fastest * period / FINE_STEP)


def estimate(
    recording: xarray.Dataset,
    prediction: PredictionInC,
    settings: Settings,
    *,
    units: Mapping[str, str] | None = None,
) -> xarray.Dataset:
    """Return the estimates of a filter at every sample of a recording.

    Args:
        recording: A trace whose readings are the prediction's inputs and outputs; its truth is not used.
        settings: Noises, start and gate.
        units: Units of inputs and outputs, to which those of the recording are converted.

    Returns:
        `mean` and `sd` (time, state), `innovation` (time, output) as reading minus expected reading, `nis` (time) with
        its degrees of freedom `readings` (time). The first sample is the start. The attribute `ended` is empty for a
        valid filter. Otherwise it states why and from when on its estimates are invalid: the filter diverged, and later
        values are NaN, or it is lost (`railgrip.estimators.consistency.loss_step`). `nis_ratio` is the median of NIS
        over its expected one, NaN without readings. `repairs` has a line for each error in the file that was mended,
        `warnings` one for each disagreement between signals of the recording.

    Raises:
        EstimationError: A signal is missing or in another unit, the grid is uneven, or an input is NaN.
        EstimatorError: Noises or start do not fit the model.
    """
    data = filter_data(recording, prediction, settings, units)
    filter_ = CompiledFilter.of_context(context_of(prediction, settings, data))
    first = filter_.start(data.mean, data.covariance)
    beliefs, problem = _follow(filter_, first, data)
    count, done = len(data.readings), len(beliefs.mean)

    def at_samples(start: Matrix | float, steps: Matrix) -> Matrix:
        rows = np.full((1 + count, *steps.shape[1:]), np.nan)
        rows[0], rows[1 : 1 + done] = start, steps
        return rows

    times = recording["time"].values[1 : 1 + done]
    unused = np.isfinite(data.readings[:done]) & (beliefs.used == 0.0)
    if "speed" in prediction.states:  # at standstill the models do not hold: brakes would turn the train back
        unused &= (beliefs.mean[:, prediction.states.index("speed")] > STANDSTILL)[:, None]
    rejected = _rejected(prediction.outputs, times, unused, data)
    ratio = nis_ratio(beliefs.squared_innovation, beliefs.degrees)
    return xarray.Dataset(
        {
            "mean": (("time", "state"), at_samples(first.mean, beliefs.mean)),
            "sd": (("time", "state"), at_samples(first.deviation, np.sqrt(beliefs.variance))),
            "innovation": (("time", "output"), at_samples(np.nan, data.readings[:done] - beliefs.expectation)),
            "nis": (("time",), at_samples(np.nan, beliefs.squared_innovation)),
            "readings": (("time",), np.nan_to_num(at_samples(0.0, beliefs.degrees))),
        },
        coords={"time": recording["time"], "state": list(prediction.states), "output": list(prediction.outputs)},
        attrs={
            "ended": _end(beliefs, problem, data.readings[:done], recording["time"].values),
            "period": data.period,
            "name": recording.attrs.get("name", ""),
            "nis_ratio": np.nan if ratio is None else ratio,
            "repairs": "\n".join(recording.attrs.get("flags", ())),
            "warnings": "\n".join([*recording.attrs.get("warnings", ()), *rejected]),
        },
    )


def _rejected(outputs: Sequence[str], time: Vector, where: NDArray[np.bool_], data: FilterData) -> list[str]:
    """Return a sentence for each interval in which the filter rejected samples of a reading as outliers."""
    near = max(1, round(REJECTED_TOGETHER / data.period))
    sentences: list[str] = []
    for name, rejected in zip(outputs, where.T, strict=True):
        spans = intervals(binary_closing(rejected, np.ones(near + 1, dtype=np.bool_)) | rejected)
        for first, last in spans[:MOST_REJECTIONS]:
            count = int(rejected[first : last + 1].sum())
            if count > 1:
                sentences.append(
                    f"{name} contradicts the other signals from {time[first]:.3f} s to {time[last]:.3f} s: {count} of "
                    "its samples are further from their expectation than outlier_limit and are not used; compare the "
                    "sensor, and the brake inputs there."
                )
        if len(spans) > MOST_REJECTIONS:
            sentences.append(
                f"{name} contradicts the other signals {len(spans) - MOST_REJECTIONS} more times until "
                f"{time[spans[-1][1]]:.3f} s."
            )
    return sentences


def _follow(filter_: CompiledFilter, first: GaussianEstimate, data: FilterData) -> tuple[FilterRecord, str]:
    try:
        return filter_.follow(first, data.inputs, data.readings_by_step, every=data.steps), ""
    except FilterDiverged as problem:
        # The estimates before that are valid.
        valid = problem.after // data.steps * data.steps
        return filter_.follow(first, data.inputs[:valid], data.readings_by_step[:valid], every=data.steps), problem.why


def _end(beliefs: FilterRecord, problem: str, readings: Matrix, time: Vector) -> str:
    lost = loss_step(beliefs.squared_innovation, beliefs.degrees, np.isfinite(readings).sum(axis=1))
    if lost is not None:
        return (
            f"Filter: lost; its innovations are more than {FAR:g} times their claimed deviations, or it rejects most "
            f"readings as outliers. At {time[lost + 1]:.3f} s."
        )
    return f"{problem} At {time[len(beliefs.mean) + 1]:.3f} s." if problem else ""


def _inputs(recording: xarray.Dataset, prediction: PredictionInC, units: Mapping[str, str]) -> Matrix:
    """Return the inputs at each sample, shape (k + 1, inputs)."""
    names = prediction.inputs
    columns = samples(recording, names, [units.get(name) for name in names])
    for name, values in zip(names, columns.T, strict=True):
        if np.isnan(values).any():
            at = recording["time"].values[int(np.argmax(np.isnan(values)))]
            raise EstimationError(
                f"recording: input {name} is not a number at {at:.3f} s; a filter needs its inputs at every sample, "
                "fill or cut the gap."
            )
    return columns


def _by_step(inputs: Matrix, steps: int, between: str) -> Matrix:
    """Return the inputs over each step: held at the sample before, or those of the line to the next in its middle."""
    before, after = inputs[:-1], inputs[1:]
    if between != "mean":
        return np.repeat(before, steps, axis=0)
    if steps == 1:
        return 0.5 * (before + after)
    share = ((np.arange(steps) + 0.5) / steps)[:, None]
    return (before[:, None] + share * (after - before)[:, None]).reshape(-1, inputs.shape[1])


def by_name(what: str, values: Mapping[str, float], names: Sequence[str]) -> Matrix:
    """Return the value of each name, given under that name, the name without its index, or the symbol of a state.

    Raises:
        EstimationError: A name has no value, or a value has no name.
    """
    values, choice = _by_state(what, values, names), _choice(names)
    missing = [name for name in names if name not in values and ElementName.of(name).array not in values]
    problems = [f"{what} lacks {', '.join(missing)}; it has {', '.join(values) or 'nothing'}."] if missing else []
    strange = [name for name in values if name not in choice]
    if strange:
        problems.append(f"{what} has {', '.join(strange)}, the model has {', '.join(names)}.")
    if problems:
        raise EstimationError("\n".join(problems))
    return np.array([values.get(name, values.get(ElementName.of(name).array, np.nan)) for name in names])


def _choice(names: Sequence[str]) -> set[str]:
    return {*names, *(ElementName.of(name).array for name in names)}


def _by_state(what: str, values: Mapping[str, float], names: Sequence[str]) -> dict[str, float]:
    """Return values with the name of a state in place of its symbol."""
    choice = _choice(names)
    found = {name: name if name in choice else state_name(name) for name in values}
    twice = [name for name, state in found.items() if state != name and state in values]
    if twice:
        raise EstimationError(f"{what} has {twice[0]} and {found[twice[0]]}, which are the same state.")
    return {found[name]: value for name, value in values.items()}


def _start(start: Mapping[str, float], states: Sequence[str], outputs: Sequence[str], readings: Matrix) -> Matrix:
    first, problems = dict[str, float](), list[str]()
    start = _by_state("[start] mean", start, states)
    for state, reading in start_by_reading(states, outputs).items():
        if state in start or ElementName.of(state).array in start:
            continue
        column = readings[:, outputs.index(reading)]
        finite = np.flatnonzero(np.isfinite(column))
        if finite.size:
            first[state] = float(column[finite[0]])
        else:
            problems.append(
                f"{state} begins at the first reading of {reading}, and the recording has none; map {reading} in "
                f"[data.columns], or write {state} in [start] mean."
            )
    if problems:
        raise EstimationError("\n".join(problems))
    return by_name("[start] mean", {**first, **start}, states)


@dataclass(frozen=True, slots=True, kw_only=True)
class FilterRun:
    """Estimates of a filter at every sample of a recording of k steps, NaN from where it diverged.

    Attributes:
        mean, variance: Shape (k + 1, n), the start first.
        squared_innovation: Normalised innovation squared of each step, shape (k,); empty without innovations.
        degrees: Number of readings of each step, shape (k,).
        ended: Sentence on where and why it diverged; empty if it did not.
        microseconds: Processor time of a step [µs].
    """

    mean: Matrix
    variance: Matrix
    squared_innovation: Vector = field(default_factory=lambda: np.zeros(0))
    degrees: Vector = field(default_factory=lambda: np.zeros(0))
    ended: str = ""
    microseconds: float = 0.0

    @property
    def nis_ratio(self) -> float | None:
        """Median of the normalised innovation squared over its expected one; None without innovations."""
        return nis_ratio(self.squared_innovation, self.degrees) if self.squared_innovation.any() else None


def run_kind(kind: str, context: FilterContext, data: FilterData) -> FilterRun:
    """Return the estimates of a kind of `railgrip.estimators.filters`.

    Raises:
        EstimationError: The kind does not exist, or takes a train in parts.
    """
    known = [name for name in registry.modules(registry.FILTERS) if _kind(name).form != "parts"]
    if kind not in known:
        hint = did_you_mean(kind, known) or f"there are {', '.join(known)}."
        raise EstimationError(f"there is no filter '{kind}' for a recording; {hint}")
    filter_ = _kind(kind).of_context(context)
    count, n = len(data.readings), data.mean.size
    mean, variance = np.full((count + 1, n), np.nan), np.full((count + 1, n), np.nan)
    nis, degrees = np.zeros(count), np.zeros(count)
    mean[0], variance[0] = filter_.mean, np.diagonal(filter_.covariance)
    ended, begin = "", process_time()
    readings = data.readings_by_step
    for step in range(count * data.steps):
        filter_.inputs[:], filter_.readings[:] = data.inputs[step], readings[step]
        k = step // data.steps
        try:
            filter_.advance()
        except FilterDiverged as problem:
            ended = f"{problem} At step {k + 1}."
            break
        if (step + 1) % data.steps:
            continue
        mean[k + 1], variance[k + 1] = filter_.mean, np.diagonal(filter_.covariance)
        nis[k], degrees[k] = filter_.squared_innovation, filter_.selection.sum()
    return FilterRun(
        mean=mean,
        variance=variance,
        squared_innovation=nis,
        degrees=degrees,
        ended=ended,
        microseconds=1e6 * (process_time() - begin) / count,
    )


def context_of(prediction: PredictionInC, settings: Settings, data: FilterData) -> FilterContext:
    """Return the model, noises and start of a filter.

    Raises:
        EstimationError: The noises do not match the states and outputs.
    """
    limit = settings.outlier_limit
    return FilterContext(
        prediction=prediction,
        process_noise=by_name("[noise] process", settings.process, prediction.states),
        reading_noise=by_name("[noise] readings", settings.readings, prediction.outputs),
        period=data.step,
        gate=settings.gate,
        outlier_limit=None if limit is None else [limit] * len(prediction.outputs),
        mean=data.mean,
        covariance=data.covariance,
    )


def estimate_several(
    recording: xarray.Dataset,
    prediction: PredictionInC,
    settings: Settings,
    filters: Sequence[str],
    *,
    units: Mapping[str, str] | None = None,
) -> xarray.Dataset:
    """Return the estimates of several kinds of filters, with the same prediction, noises and start.

    Arguments are those of `railgrip.estimation.run.estimate`.

    Returns:
        `mean` and `sd` (filter, time, state), `nis` (filter, time) with its degrees of freedom `readings`, and `ended`
        (filter), empty for a valid filter.

    Raises:
        EstimationError: A filter does not exist, or as `railgrip.estimation.run.estimate`.
    """
    data = filter_data(recording, prediction, settings, units)
    context = context_of(prediction, settings, data)
    runs = [run_kind(kind, context, data) for kind in filters]
    dimensions = ("filter", "time", "state")
    return xarray.Dataset(
        {
            "mean": (dimensions, np.stack([run.mean for run in runs])),
            "sd": (dimensions, np.sqrt(np.stack([run.variance for run in runs]))),
            "nis": (dimensions[:2], np.stack([np.append(np.nan, run.squared_innovation) for run in runs])),
            "readings": (dimensions[:2], np.stack([np.append(0.0, run.degrees) for run in runs])),
            "ended": (dimensions[:1], [run.ended for run in runs]),
        },
        coords={"filter": list(filters), "time": recording["time"], "state": list(prediction.states)},
        attrs={"period": data.period, "name": recording.attrs.get("name", "")},
    )


def _kind(name: str) -> type[FilterKind]:
    return registry.part(registry.FILTERS, name, FilterKind)


WINDOW = 0.5
"""Time over which the slope of a wheelset speed is taken [s]; a slide changes it within some tenths of a second."""
ITERATIONS = 5
"""Of Newton's method; the balances are nearly linear in adhesion and deflection."""


def start_in_braking(
    prediction: Prediction, mean: Vector, deviation: Vector, inputs: Vector, readings: Matrix, period: float
) -> tuple[Vector, Matrix]:
    """Return mean and covariance of the states at the first sample, shapes (n,) and (n, n).

    They are those that are given unless the brakes act: unless adhesion of a steady braking differs from that of `mean`
    by more than its deviation.

    Args:
        prediction: The model.
        mean: Mean of the states for a released brake, shape (n,).
        deviation: Standard deviations, shape (n,).
        inputs: Inputs at the first sample, shape (nu,).
        readings: Readings from the first sample on, NaN where missing, shape (k, m).
        period: Time between samples [s].
    """
    states, covariance = prediction.states, np.diag(deviation**2)
    rotating, adhesion, pads, moving = (
        _places(states, base) for base in ("wheelset_speed", "group_adhesion", "pad_friction", "ddz")
    )
    unknown = [*adhesion, *_places(states, "dz")]
    rates = [*rotating, *moving]
    if not adhesion or not rotating or not pads:
        return mean, covariance
    count = max(2, round(WINDOW / period) + 1)
    slopes = np.zeros(len(rates))
    for place, state in enumerate(states[k] for k in rotating):
        values = readings[:count, prediction.outputs.index(state)] if state in prediction.outputs else np.zeros(0)
        slopes[place] = _slope(values, period)
    steady = mean.copy()
    for _ in range(ITERATIONS):
        missing = slopes - prediction.derivative(steady, inputs)[rates]
        by_unknown = prediction.derivative_jacobian(steady, inputs)[np.ix_(rates, unknown)]
        if not (np.isfinite(missing).all() and np.isfinite(by_unknown).all()):
            return mean, covariance
        steady[unknown] += np.linalg.lstsq(by_unknown, missing, rcond=None)[0]
    if not np.any(np.abs(steady - mean)[adhesion] > deviation[adhesion]):
        return mean, covariance
    jacobian = prediction.derivative_jacobian(steady, inputs)
    by_friction = -np.linalg.lstsq(jacobian[np.ix_(rates, unknown)], jacobian[np.ix_(rates, pads)], rcond=None)[0]
    friction = covariance[np.ix_(pads, pads)]
    covariance[np.ix_(unknown, pads)] = by_friction @ friction
    covariance[np.ix_(pads, unknown)] = (by_friction @ friction).T
    covariance[np.ix_(unknown, unknown)] += by_friction @ friction @ by_friction.T
    return steady, covariance


def _places(states: Sequence[str], base: str) -> list[int]:
    return [k for k, state in enumerate(states) if ElementName.of(state).array == base]


def _slope(values: Vector, period: float) -> float:
    """Return the slope of a signal by Theil and Sen, which outliers do not tilt; 0 for fewer than two samples."""
    at = np.flatnonzero(np.isfinite(values))
    if at.size < 2:
        return 0.0
    first, second = np.triu_indices(at.size, 1)
    return float(np.median((values[at[second]] - values[at[first]]) / (period * (at[second] - at[first]))))
