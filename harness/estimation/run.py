"""A filter over a recording: mean and spread of every state at every sample, and what the readings said."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Literal

import casadi as ca
import numpy as np
import xarray

from railgrip.errors import EstimationError, FilterDiverged
from railgrip.estimators.belief import Estimate, Matrix
from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.consistency import FAR, lost_at, nis_ratio
from railgrip.estimators.ekf import ExtendedKalmanFilter
from railgrip.estimators.gate import Gate
from railgrip.estimators.prediction import CasadiPrediction
from railgrip.estimators.running import Running
from railgrip.fmus.native import Model, lower
from railgrip.trace.samples import period_of, samples

READ_STATES = {"v": "speed", "w": "wheelset_speed"}
"""States that a reading shows as they are; where `start` leaves them out they begin at its first sample."""

AT_ONCE = 10_000
"""Samples between two words of progress: a tenth of a second."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """What a filter is told besides its model.

    A name without index stands for all elements of an array, a name with one (`w[2]`) for that element and before
    the other.

    Attributes:
        process: Density of the noise of each state, (unit of the state)²/s; see `per_step` for tables that
            give what one step adds.
        readings: Variance of each reading.
        start: Mean of each state at the first sample; those in `READ_STATES` may be left out.
        start_deviation: Standard deviation of each state at the first sample.
        gate: States to hold still and when, or None.
        outlier_limit: Leave out readings further off than so many standard deviations; None uses all.
        between: What the inputs are between two samples: `held` at the earlier one, as a digital controller holds
            its commands, or the `mean` of both, for inputs that were measured and move all the time.
    """

    process: Mapping[str, float]
    readings: Mapping[str, float]
    start: Mapping[str, float]
    start_deviation: Mapping[str, float]
    gate: Gate | None = None
    outlier_limit: float | None = None
    between: Literal["held", "mean"] = "held"


def per_step(variances: Mapping[str, float], period: float) -> dict[str, float]:
    """Return densities from the covariance that one step of a discrete filter adds, as tables of papers give it.

    The meaning of such a table hangs on its period: halving it doubles the noise a second.
    """
    return {name: variance / period for name, variance in variances.items()}


def prediction_of(model: str, parameters: Mapping[str, float] | None = None) -> CasadiPrediction:
    """Return the prediction of a class of RailBraking.FMUs, its other parameters at their defaults.

    Args:
        model: Such as `RollerRigPrediction`, or a full class name.
        parameters: By name, SI.

    Raises:
        EstimationError: There is no such parameter.
        railgrip.errors.InputError: There is no such class.
    """
    source = model_of(model)
    values = dict(parameters or {})
    defaults = {variable.name: variable.start for variable in source.parameters}
    strange = [name for name in values if name not in defaults]
    if strange:
        raise EstimationError(f"{model} has no parameter {', '.join(strange)}; it has {', '.join(defaults)}.")
    return CasadiPrediction(source, defaults | values)


@cache
def model_of(model: str) -> Model:
    """Return a class of RailBraking.FMUs as functions; translated once in a process."""
    return lower(model if "." in model else f"RailBraking.FMUs.{model}")


def units_of(model: str) -> dict[str, str]:
    """Return the unit of every state, input and output of a prediction."""
    source = model_of(model)
    return {v.name: v.unit for v in (*source.states, *source.inputs, *source.outputs)}


def estimate(
    recording: xarray.Dataset,
    prediction: CasadiPrediction,
    settings: Settings,
    *,
    units: Mapping[str, str] | None = None,
    compiled: bool = True,
    covariance: bool = False,
    progress: Callable[[int, int], None] = lambda count, of: None,
) -> xarray.Dataset:
    """Return what a filter believes at every sample of a recording.

    Args:
        recording: A trace whose readings are the prediction's inputs and outputs; its truth is not touched.
        prediction: The model.
        settings: Noises, start and gate.
        units: Of inputs and outputs, which the recording's are converted to where given.
        compiled: In C; otherwise the filter in numpy, which needs no compiler.
        covariance: Keep the whole covariance at every sample, too.
        progress: Told how many of how many samples are done.

    Returns:
        `mean` and `sd` (time, state), `innovation` (time, output) as reading minus expected reading, `nis` (time)
        with its degrees of freedom `readings` (time), and `covariance` (time, state, state_) when asked for. The
        first sample is the start. The attribute `ended` says why its beliefs mean nothing, and from when on, else it is
        empty: the filter could not go on, when the rest is NaN, or is lost (`railgrip.estimators.consistency.lost_at`).
        `nis_ratio` is the median of NIS over its expected one, NaN where nothing was read.

    Raises:
        EstimationError: A signal is missing or in another unit, the grid is uneven, or an input is NaN.
        EstimatorError: Noises or start do not fit the model.
    """
    states, outputs = prediction.states, prediction.outputs
    unit_of_name = dict(units or {})
    period = period_of(recording)
    inputs = _inputs(recording, prediction, unit_of_name, settings.between)
    signals = samples(recording, outputs, [unit_of_name.get(name) for name in outputs])
    process = by_name("process", settings.process, states)
    readings = by_name("readings", settings.readings, outputs)
    parts = (prediction, process, readings, period, settings.gate, settings.outlier_limit)
    filter_ = CompiledFilter(*parts) if compiled else ExtendedKalmanFilter(*parts)
    belief = filter_.start(
        _start(settings.start, states, outputs, signals),
        by_name("start_deviation", settings.start_deviation, states) ** 2,
    )
    if isinstance(filter_, CompiledFilter) and not covariance:
        result = _follow(filter_, belief, inputs, signals, progress)
    else:
        result = _step_through(filter_, belief, inputs, signals, covariance, progress)
    mean = result.mean
    innovation = signals - (
        _expectations(prediction, mean, inputs, period, settings.gate) if result.expected is None else result.expected
    )
    ratio = nis_ratio(result.nis[: result.done], result.used[: result.done])
    variables: dict[str, tuple[tuple[str, ...], Matrix]] = {
        "mean": (("time", "state"), mean),
        "sd": (("time", "state"), result.sd),
        "innovation": (("time", "output"), innovation),
        "nis": (("time",), result.nis),
        "readings": (("time",), result.used),
    }
    if result.covariance is not None:
        variables["covariance"] = (("time", "state", "state_"), result.covariance)
    return xarray.Dataset(
        variables,
        coords={"time": recording["time"], "state": list(states), "output": list(outputs)},
        attrs={
            "ended": _end(result, signals, recording["time"].values),
            "period": period,
            "name": recording.attrs.get("name", ""),
            "nis_ratio": np.nan if ratio is None else ratio,
        },
    )


def _end(result: "_Beliefs", readings: Matrix, time: Matrix) -> str:
    """Return since when the beliefs mean nothing, in a sentence, or nothing."""
    # The first sample is the start: it was read, but no step used it.
    divergence = lost_at(
        result.nis[1 : result.done], result.used[1 : result.done], np.isfinite(readings[1 : result.done]).sum(axis=1)
    )
    if divergence is not None:
        return (
            f"Filter: lost; its innovations are more than {FAR:g} times what it claims, or it leaves out most of what "
            f"it reads. At {time[divergence + 1]:.3f} s."
        )
    return f"{result.problem} At {time[result.done]:.3f} s." if result.problem else ""


@dataclass(slots=True, kw_only=True)
class _Beliefs:
    """What a filter said of every sample, filled as it goes; NaN from where it diverged.

    Attributes:
        mean: Shape (k, n), as is `sd`.
        sd: Standard deviations.
        nis: Shape (k,), as is `used`, its degrees.
        used: Readings used.
        expected: Readings before they were seen, shape (k, m); None where the filter does not tell.
        covariance: Shape (k, n, n), or None.
        done: Samples.
        problem: Why it diverged, or empty.
    """

    mean: Matrix
    sd: Matrix
    nis: Matrix
    used: Matrix
    expected: Matrix | None
    covariance: Matrix | None
    done: int
    problem: str = ""

    @classmethod
    def of(cls, first: Estimate, count: int, readings: int | None, covariance: bool) -> "_Beliefs":
        n = first.mean.size
        result = cls(
            mean=np.full((count, n), np.nan),
            sd=np.full((count, n), np.nan),
            nis=np.full(count, np.nan),
            used=np.zeros(count),
            expected=None if readings is None else np.full((count, readings), np.nan),
            covariance=np.full((count, n, n), np.nan) if covariance else None,
            done=0,
        )
        result.take(first)
        return result

    def take(self, belief: Estimate) -> None:
        k = self.done
        self.mean[k], self.sd[k] = belief.mean, belief.deviation
        if self.covariance is not None:
            self.covariance[k] = belief.covariance
        self.done = k + 1


def _follow(
    filter_: CompiledFilter, belief: Estimate, inputs: Matrix, readings: Matrix, progress: Callable[[int, int], None]
) -> _Beliefs:
    """Run a compiled filter in calls of many samples each."""
    count = len(readings)
    result = _Beliefs.of(belief, count, readings.shape[1], covariance=False)
    assert result.expected is not None
    end = count
    while result.done < end:
        rows = slice(result.done, min(result.done + AT_ONCE, end))
        try:
            block = filter_.follow(belief, inputs[rows], readings[rows])
        except FilterDiverged as problem:
            # Up to there its beliefs are good, and worth having.
            end, result.problem = result.done + problem.after, problem.why
            continue
        result.mean[rows], result.sd[rows], result.expected[rows] = block.mean, np.sqrt(block.variance), block.expected
        result.nis[rows], result.used[rows] = block.squared, block.used
        result.done = rows.stop
        belief = Estimate(mean=filter_.mean.copy(), covariance=filter_.covariance.copy())
        progress(result.done, count)
    return result


def _step_through(
    filter_: CompiledFilter | ExtendedKalmanFilter,
    belief: Estimate,
    inputs: Matrix,
    readings: Matrix,
    covariance: bool,
    progress: Callable[[int, int], None],
) -> _Beliefs:
    """Run a filter sample by sample."""
    count = len(readings)
    result = _Beliefs.of(belief, count, None, covariance)
    running = (
        filter_
        if isinstance(filter_, CompiledFilter)
        else (Running(filter_, belief, inputs=inputs.shape[1], outputs=readings.shape[1]))
    )
    for k in range(1, count):
        running.held[:], running.seen[:] = inputs[k], readings[k]
        try:
            running.advance()
        except FilterDiverged as problem:
            result.problem = str(problem)
            break
        result.nis[k], result.used[k] = running.squared_innovation, running.used.sum()
        result.take(Estimate(mean=running.mean.copy(), covariance=running.covariance.copy()))
        if k % AT_ONCE == 0:
            progress(k, count)
    progress(count, count)
    return result


def _inputs(recording: xarray.Dataset, prediction: CasadiPrediction, units: Mapping[str, str], between: str) -> Matrix:
    """Return for each sample the inputs of the period that ends there, shape (k, nu); the first row is not used."""
    names = prediction.inputs
    columns = samples(recording, names, [units.get(name) for name in names])
    for name, values in zip(names, columns.T, strict=True):
        if np.isnan(values).any():
            at = recording["time"].values[int(np.argmax(np.isnan(values)))]
            raise EstimationError(
                f"recording: input {name} is not a number at {at:.3f} s; a filter must know its inputs, "
                "fill or cut the gap."
            )
    earlier = np.vstack([columns[:1], columns[:-1]])
    return 0.5 * (earlier + columns) if between == "mean" else earlier


def by_name(what: str, values: Mapping[str, float], names: Sequence[str]) -> Matrix:
    """Return the value of each name, by itself or by what stands before its index.

    Raises:
        EstimationError: A name has no value, or a value no name.
    """
    missing = [name for name in names if name not in values and name.partition("[")[0] not in values]
    if missing:
        raise EstimationError(f"settings: {what} lacks {', '.join(missing)}; it has {', '.join(values) or 'nothing'}.")
    allowed = {*names, *(name.partition("[")[0] for name in names)}
    strange = [name for name in values if name not in allowed]
    if strange:
        raise EstimationError(f"settings: {what} has {', '.join(strange)}, the model has {', '.join(names)}.")
    return np.array([values.get(name, values.get(name.partition("[")[0], np.nan)) for name in names])


def _start(start: Mapping[str, float], states: Sequence[str], outputs: Sequence[str], readings: Matrix) -> Matrix:
    """Return the mean at the first sample."""
    from_readings: dict[str, float] = {}
    for state in states:
        base, bracket, index = state.partition("[")
        reading = READ_STATES.get(base, "") + bracket + index
        if reading in outputs:
            column = readings[:, outputs.index(reading)]
            finite = np.flatnonzero(np.isfinite(column))
            if finite.size:
                from_readings[state] = float(column[finite[0]])
    # An element that the user names goes before the reading; so does the name of its array.
    start_states = {state for state in states if state in start or state.partition("[")[0] in start}
    return by_name("start", {**{s: x for s, x in from_readings.items() if s not in start_states}, **start}, states)


def _expectations(
    prediction: CasadiPrediction, mean: Matrix, inputs: Matrix, period: float, gate: Gate | None
) -> Matrix:
    """Return what the readings were expected to be, shape (k, m), from the belief one sample before.

    The compiled filter does not tell; this repeats its prediction of the mean for all samples at once.
    """
    of = prediction.equations
    free = ca.SX.sym("free", len(prediction.states))
    slope = ca.Function("slope", [of.x, of.u, of.p, free], [of.derivative * free])
    k1 = slope(of.x, of.u, of.p, free)
    k2 = slope(of.x + 0.5 * period * k1, of.u, of.p, free)
    k3 = slope(of.x + 0.5 * period * k2, of.u, of.p, free)
    k4 = slope(of.x + period * k3, of.u, of.p, free)
    ahead = of.x + period / 6.0 * (k1 + 2 * k2 + 2 * k3 + k4)
    output = ca.Function("output", [of.x, of.u, of.p], [of.output])
    expected = ca.Function("expected", [of.x, of.u, of.p, free], [output(ahead, of.u, of.p)])
    count = len(mean)
    moving = np.ones((count, len(prediction.states)))
    if gate is not None:
        for state, gate_input in zip(gate.states, gate.inputs, strict=True):
            is_closed = inputs[:, prediction.inputs.index(gate_input)] < gate.threshold
            moving[is_closed, prediction.states.index(state)] = 0.0
    before = np.vstack([mean[:1], mean[:-1]])
    rates = expected.map(count)(before.T, inputs.T, np.tile(prediction.parameters[:, None], count), moving.T)
    increments = np.array(rates, dtype=np.float64).T
    increments[0] = np.nan
    return increments
