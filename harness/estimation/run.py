"""Run a filter over a recording: mean and standard deviation of every state, and innovations, at every sample."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Literal

import casadi as ca
import numpy as np
import xarray
from numpy.typing import NDArray
from scipy.ndimage import binary_closing

from railgrip.base.errors import EstimationError, FilterDiverged
from railgrip.base.names import ElementName, did_you_mean, state_name
from railgrip.estimation.beginning import start_in_braking
from railgrip.estimators.belief import GaussianEstimate, Matrix, Vector
from railgrip.estimators.compiled import CompiledFilter, FilterRecord
from railgrip.estimators.consistency import FAR, loss_step, nis_ratio
from railgrip.estimators.design import Gate
from railgrip.estimators.prediction import CasadiPrediction, PredictionInC, with_state_names
from railgrip.fmi import FmuPrediction, describe
from railgrip.fmus.build import build_class, fmu
from railgrip.fmus.native import Model, lower
from railgrip.fmus.native.library import LIBRARY
from railgrip.fmus.recipe import read_recipes
from railgrip.recording.flag import intervals
from railgrip.recording.samples import period_of, samples

Kind = Literal["fmu", "compiled"]
"""Form of the prediction in a filter: its FMU through FMI 2.0, or the equations of its class as C in the filter."""

READ_STATES = frozenset({"speed", "wheelset_speed"})
"""States that are measured directly; if `start` omits them they are initialised with the first reading."""

STANDSTILL = 1.0
"""Speed below which rejected readings are not reported [m/s]."""
REJECTED_TOGETHER = 0.5
"""Longest time between rejected samples of one sentence [s]."""
MOST_REJECTIONS = 3
"""Number of sentences for each reading."""
LONGEST_STEP = 1.5
"""Product of period and fastest mode of a model beyond which a filter takes several steps from sample to sample.

Classical Runge-Kutta is stable up to 2.8; see `railgrip.estimators.discretisation`.
"""
FINE_STEP = 0.6
"""Largest such product of each of several steps: one step then has an error of 0.6^5/120, below 0.1 %, in that mode."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Settings of a filter besides its model.

    A name without index refers to all elements of an array; a name with index (`w[2]`) takes precedence over it.

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


def prediction_of(
    model: str,
    parameters: Mapping[str, float] | None = None,
    outputs: Sequence[str] | None = None,
    kind: Kind = "fmu",
) -> PredictionInC:
    """Return the prediction of a class of RailBraking.Predictions; parameters that are not given have their defaults.

    An FMU is built if it is out of date; only one thread may use it at a time.

    Args:
        model: Name such as `RollerRigPrediction`, or a full class name.
        parameters: Values by name, SI.
        outputs: Expected readings, in that order, `wheelset_speed` for all its elements; None for all outputs.
        kind: Form of the prediction.

    Raises:
        EstimationError: A parameter or output does not exist.
        railgrip.base.errors.InputError: The class does not exist.
    """
    equations = equations_of(model, parameters, outputs)
    if kind == "compiled":
        return equations
    description = describe(file_of(model))
    return FmuPrediction(
        description,
        parameters=parameters or {},
        states=equations.states,
        inputs=equations.inputs,
        outputs=equations.outputs,
    ).open()


def equations_of(
    model: str, parameters: Mapping[str, float] | None = None, outputs: Sequence[str] | None = None
) -> CasadiPrediction:
    """Return the prediction as equations, which can be differentiated further and shared by threads."""
    source = model_of(model, None if outputs is None else tuple(outputs))
    values = dict(parameters or {})
    defaults = {variable.name: variable.start for variable in source.parameters}
    strange = [name for name in values if name not in defaults]
    if strange:
        raise EstimationError(
            f"{model} has no parameter {', '.join(strange)}; it has {', '.join(defaults)}"
            + did_you_mean(strange[0], defaults, before="; ")
        )
    return CasadiPrediction(source, defaults | values)


@cache
def file_of(model: str) -> Path:
    """Return the FMU of a class of RailBraking.Predictions, built if it is out of date."""
    name = model.rpartition(".")[2]
    entry = read_recipes().recipes.get(name)
    if entry is not None and entry.class_name in (model, f"RailBraking.Predictions.{model}"):
        return fmu(name)
    return build_class(model if "." in model else f"RailBraking.Predictions.{model}", LIBRARY, "me").path


@cache
def select_outputs(source: Model, model: str, outputs: tuple[str, ...]) -> Model:
    """Return a model with some of its outputs, in their order; `wheelset_speed` selects all its elements.

    Args:
        source: The model.
        model: Its name in messages.
        outputs: Names of outputs.

    Raises:
        EstimationError: An output does not exist.
    """
    names = [variable.name for variable in source.outputs]
    places = [i for output in outputs for i, name in enumerate(names) if output in (name, ElementName.of(name).array)]
    missing = [output for output in outputs if not any(output in (n, ElementName.of(n).array) for n in names)]
    if missing:
        raise EstimationError(
            f"{model} has no output {', '.join(missing)}; it has {', '.join(names)}"
            + did_you_mean(missing[0], names, before="; ")
        )
    arguments = [ca.SX.sym(f"a{i}", *source.output.size_in(i)) for i in range(source.output.n_in())]
    selection = ca.Function("output", arguments, [ca.densify(source.output(*arguments))[places]])
    return replace(source, outputs=tuple(source.outputs[i] for i in places), output=selection)


@cache
def model_of(model: str, outputs: tuple[str, ...] | None = None) -> Model:
    """Return a class of RailBraking.Predictions as functions, with all outputs or some; cached in the process.

    Raises:
        EstimationError: The class or an output does not exist.
    """
    if outputs is not None:
        return select_outputs(model_of(model), model, outputs)
    if "." in model:
        return with_state_names(lower(model))
    classes = (LIBRARY / "Predictions" / "package.order").read_text(encoding="utf-8").split()
    if model not in classes:
        hint = did_you_mean(model, classes) or f"there is {', '.join(classes)}."
        raise EstimationError(f"there is no prediction '{model}'; {hint}")
    return with_state_names(lower(f"RailBraking.Predictions.{model}"))


def start_by_reading(states: Sequence[str], outputs: Sequence[str]) -> dict[str, str]:
    """Return state → reading for the states that may be initialised with their first reading."""
    return {state: state for state in states if ElementName.of(state).array in READ_STATES and state in outputs}


def units_of(model: str | Model) -> dict[str, str]:
    """Return the unit of every state, input and output of a prediction, a model or a class by its name."""
    source = model_of(model) if isinstance(model, str) else model
    return {v.name: v.unit for v in (*source.states, *source.inputs, *source.outputs)}


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
    process = by_name("[noise] process", settings.process, prediction.states)
    noise = by_name("[noise] readings", settings.readings, prediction.outputs)
    filter_ = CompiledFilter(prediction, process, noise, data.step, settings.gate, settings.outlier_limit)
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
