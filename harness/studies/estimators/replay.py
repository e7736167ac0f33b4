"""Estimators over a recording: every one gets the same inputs and readings, through the same prediction FMU.

Noises are those of sensors and physics, times factors that were searched on training cases. Deviations include those by
errors that are in no equation of the predictions: load, inertia, radar scale, pressure transducers.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from pathlib import Path
from time import process_time
from typing import Final

import numpy as np
import xarray

from railgrip.base.errors import FilterDiverged, InputError
from railgrip.base.names import ElementName, state_name
from railgrip.estimation.models import READ_STATES, PredictionModel, of_class, of_train
from railgrip.estimation.run import FilterData, FilterRun, Settings, context_of, filter_data, run_kind
from railgrip.estimators.belief import Array, Matrix, Vector
from railgrip.estimators.design import NOISE_SETS, FilterContext, NoiseSet, pad_gate
from railgrip.estimators.ekf import ExtendedKalmanFilter
from railgrip.estimators.observability import posterior_bound
from railgrip.estimators.prediction import PredictionInC
from railgrip.estimators.smoother import smooth
from railgrip.fmi import FmuPrediction, describe
from railgrip.fmus.native import Model
from railgrip.recording.samples import knows, truth_of
from railgrip.report.comparison import flat
from railgrip.scenario.file import NamedFile, locate
from railgrip.scenario.load import read_toml
from railgrip.simulate.estimator import RELEASED_PADS
from railgrip.simulate.train_prediction import radius_of, release_pressure
from railgrip.studies.estimators.recordings import PERIOD, RecordingCase, Sensors, is_fmu, recording_of_case

FILE: Final = "noises.toml"
"""Factors of each estimator, in the folder `library` of this package; written by `--tune`."""

_SENSORS: Final = read_toml(Path(__file__).parent / "library" / "sensors.toml")
UNMODELLED: Final[Mapping[str, Mapping[str, float]]] = {kind: one["unmodelled"] for kind, one in _SENSORS.items()}
"""Sensors → standard deviations of constant errors, as in equipment/service.toml: `speed_scale`, the relative error of
the radar [1], and `pressure`, the offset of a pressure transducer [Pa]."""
READINGS: Final[Mapping[str, Mapping[str, float]]] = {kind: one["readings"] for kind, one in _SENSORS.items()}
"""Sensors → standard deviation of each reading, in its unit. A wheelset speed has the error of a tooth pitch at
50 rad/s; the bias of the accelerometer is a state."""

OUTLIER_LIMITS: Final[Mapping[str, float]] = {"wheelset_speed": 20.0}
"""Reading → largest innovation that is used, in standard deviations; all other readings are always used.

A sensor that reads 0 is far beyond this limit, the beginning of a slide is not; on the training cases a limit of 5
rejects slides. The radar has no limit: a stuck one moves the estimate before it is rejected, and then the correct
readings that follow are rejected."""

MODEL: Final = "TrainPredictionReducedDisturbed"
"""Prediction of most estimators: 15 states, so that a step in numpy takes milliseconds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """An estimator of the comparison; by default a kind of `railgrip.estimators.filters` over `MODEL`.

    Attributes:
        model: Prediction of the two-part train; another one than `MODEL` is in an extended Kalman filter.
        of_train: Class of the prediction of a train file, and whether it has the suspension; None without one.
        later: Number of later samples that a smoother uses, None for all; 0 for a filter on board.
        is_reference: Whether others are compared with it, so that it is always run.
        is_fast: Whether it is part of a quick run; a step of the others takes up to ten times as long.
        is_searched: Whether the factors of its noises are searched; all others contain an extended Kalman filter over
            the prediction of `fmu`, or equal it there, and have its noises.
    """

    model: str = MODEL
    of_train: tuple[str, bool] | None = ("ConsistPredictionDisturbed", False)
    later: int | None = 0
    is_reference: bool = False
    is_fast: bool = False
    is_searched: bool = False


CONSTANT: Final = "constant"
"""Name of the best constant of the training set."""

FORCE_BALANCE: Final = "force_balance"

ESTIMATORS: Final[Mapping[str, Entry]] = {
    CONSTANT: Entry(is_reference=True),
    FORCE_BALANCE: Entry(is_reference=True, is_searched=True),
    "fmu": Entry(is_fast=True, is_searched=True),
    "iterated": Entry(),
    "unscented": Entry(),
    "cubature": Entry(),
    "particle": Entry(),
    "moving_horizon": Entry(),
    "sage_husa": Entry(is_fast=True),
    "interacting": Entry(is_fast=True),
    "disturbance_observer": Entry(is_fast=True, is_searched=True),
    "reduced": Entry(
        model="TrainPredictionReduced", of_train=("ConsistPrediction", False), is_fast=True, is_searched=True
    ),
    "disturbed": Entry(
        model="TrainPredictionDisturbed", of_train=("ConsistPredictionDisturbed", True), is_fast=True, is_searched=True
    ),
    "loaded": Entry(model="TrainPredictionLoaded", of_train=None, is_fast=True, is_searched=True),
    "smoother": Entry(later=None, is_fast=True),
    "fixed_lag": Entry(later=10, is_fast=True),
}
"""Estimators of the study by name. `reduced` has neither track force nor bias, `disturbed` has the suspension, `loaded`
the load too."""

REFERENCES: Final = tuple(name for name, entry in ESTIMATORS.items() if entry.is_reference)
SEARCHED: Final = tuple(name for name, entry in ESTIMATORS.items() if entry.is_searched)


def entry_of(estimator: str) -> Entry:
    """Return the declaration of an estimator; kinds and FMUs that are not in the table are as `unscented`."""
    return ESTIMATORS.get(estimator, Entry())


ALL: Final = "all"
FACTORS: Final = (
    ALL,
    "process.group_adhesion",
    "process.pad_friction",
    "process.wheelset_speed",
    "process.d",
    "readings.wheelset_speed",
    "readings.acceleration",
)
"""Factors of standard deviations that are searched, by table and name of a `NoiseSet`.

`all` multiplies every one: the gains of a Kalman filter remain, its deviations change.
"""


def noise_of(estimator: str, sensors: Sensors, factors: Mapping[str, float] | None = None) -> NoiseSet:
    """Return the noises of an estimator for a class of sensors.

    Args:
        estimator: Name in the study; an unknown one has the noises of `fmu`.
        sensors: Class of sensors.
        factors: Factors by name, 1 where omitted; None for those of the file.
    """
    chosen = factors_of(estimator, sensors) if factors is None else factors
    physical, common = NOISE_SETS["loaded_service"], chosen.get(ALL, 1.0)
    # The process noise of adhesion of a prediction with a track force, see noises.toml.
    process = {**physical.process, "group_adhesion": NOISE_SETS["disturbed_service"].process["group_adhesion"]}

    def scaled(table: str, values: Mapping[str, float]) -> dict[str, float]:
        return {name: value * common * chosen.get(f"{table}.{name}", 1.0) for name, value in values.items()}

    return NoiseSet(
        name=f"{estimator}, {sensors} sensors",
        process=scaled("process", process),
        readings=scaled("readings", READINGS[sensors]),
        start=scaled("start", physical.start),
    )


def factors_of(estimator: str, sensors: Sensors) -> Mapping[str, float]:
    """Return the factors of an estimator from the file; empty if the file lacks it."""
    found = read_factors(Path(__file__).parent / "library" / FILE)
    return found.get((estimator if estimator in SEARCHED else "fmu", sensors), {})


def read_factors(path: Path) -> dict[tuple[str, str], Mapping[str, float]]:
    """Return the factors in a file of `--tune` by estimator and sensors."""
    return {
        (estimator, sensors): flat(factors)
        for estimator, rows in read_toml(path).items()
        for sensors, factors in rows.items()
    }


LOAD_DEVIATION: Final = NOISE_SETS["loaded_service"].start["payload"]
"""Relative standard deviation of the load, from empty to laden: adhesion is a force over a load that is not read."""

INERTIA_DEVIATION: Final = 0.1 / math.sqrt(3.0)
"""Relative standard deviation of the inertia of the wheelsets, even within 10 %: wheels wear by some 10 % of it."""

RATE_TIME: Final = 0.1
"""Time over which the acceleration of the wheelsets is taken [s]; noise of their speeds gives it a few rad/s²."""


def force_over_load_deviation() -> float:
    """Return √E(1/ℓ − 1)², the relative deviation of a known force over a load ℓ that is even within 1 ± √3 σ_load.

    It exceeds σ_load, as a load of 1 − h changes the ratio more than one of 1 + h.
    """
    half = math.sqrt(3.0) * LOAD_DEVIATION
    mean, square = math.log((1.0 + half) / (1.0 - half)) / (2.0 * half), 1.0 / (1.0 - half**2)
    return math.sqrt(square - 2.0 * mean + 1.0)


def with_unmodelled(
    recording: xarray.Dataset,
    states: Sequence[str],
    mean: Matrix,
    variance: Matrix,
    sensors: Sensors,
    model: Model | PredictionModel,
    effect: Vector,
) -> Matrix:
    """Return the variances of an estimator plus those of the errors in no equation, shape (k, n).

    Adhesion α is (τ + J dω/dt)/(r N). It has α² E(1/ℓ − 1)² by the load ℓ, unless that is a state, and
    (σ_J/g dω/dt)² by the inertia J, g = r N/J. Pad friction μ has (μ σ_p/(p − p₀))², with the pressure p₀
    of the return spring, as the torque determines μ (p − p₀). Speed v has (v σ_scale)². All are independent of the
    errors of the estimator, and of first order but for the load.

    Args:
        recording: Samples of the estimates, at `PERIOD`.
        states: Names of the states.
        mean, variance: Estimates, shape (k, n).
        sensors: Class of sensors.
        model: Prediction with the parameters of the pads.
        effect: g = ∂(dω/dt)/∂α of each group [rad/s²], shape (groups,).
    """
    bases = [ElementName.of(name).array for name in states]
    of = {
        base: [k for k, name in enumerate(bases) if name == base]
        for base in ("speed", "wheelset_speed", "group_adhesion", "pad_friction")
    }
    errors, values = UNMODELLED[sensors], {variable.name: variable.start for variable in model.parameters}
    threshold, spring = (
        np.array([release_pressure(values, group, force) for group in range(len(of["pad_friction"]))])
        for force in (RELEASED_PADS, 0.0)
    )
    pressure = np.nan_to_num(recording["reading_cylinder_pressure"].values)
    offset = errors["pressure"] / (np.maximum(pressure, threshold) - spring)
    total = variance.copy()
    total[:, of["speed"]] += (mean[:, of["speed"]] * errors["speed_scale"]) ** 2
    if "payload" not in states:
        total[:, of["group_adhesion"]] += (mean[:, of["group_adhesion"]] * force_over_load_deviation()) ** 2
    total[:, of["group_adhesion"]] += (INERTIA_DEVIATION * _rate(mean[:, of["wheelset_speed"]]) / effect) ** 2
    total[:, of["pad_friction"]] += (mean[:, of["pad_friction"]] * offset) ** 2
    return total


def _rate(speeds: Matrix) -> Matrix:
    """Return the mean derivative of the last `RATE_TIME`, 0 before it, shape (k, groups)."""
    steps = round(RATE_TIME / PERIOD)
    rate = np.zeros_like(speeds)
    rate[steps:] = (speeds[steps:] - speeds[:-steps]) / RATE_TIME
    return rate


def model_of_estimator(estimator: str, train: str = "") -> PredictionModel:
    """Return the prediction model of an estimator on board of a train, or of the two-part train for an empty name.

    Raises:
        InputError: The estimator has no prediction for a train file.
    """
    entry = entry_of(estimator)
    if not train:
        return of_class(entry.model)
    if entry.of_train is None:
        raise InputError(f"{estimator} has no prediction for a train file; leave out --train, or this estimator.")
    class_name, has_suspension = entry.of_train
    path = locate(train, "trains")
    return of_train(NamedFile(entry=train, path=path), class_name, has_suspension=has_suspension)


@cache
def _prediction(estimator: str, train: str) -> PredictionInC:
    return model_of_estimator(estimator, train).prediction({})


@cache
def _own_prediction(file: str) -> tuple[FmuPrediction, dict[str, float]]:
    """Return the prediction in a user's FMU, and the start values of its states."""
    description = describe(Path(file))
    inputs, outputs = description.names("input"), description.names("output")
    names = tuple(map(state_name, description.states))
    own = FmuPrediction(description, parameters={}, states=names, inputs=inputs, outputs=outputs).open()
    return own, dict(zip(own.states, own.start.tolist(), strict=True))


def _prediction_of(estimator: str, train: str) -> PredictionInC:
    if is_fmu(estimator):
        return _own_prediction(estimator)[0]
    return _prediction("" if entry_of(estimator).model == MODEL else estimator, train)


def _radii(estimator: str, train: str) -> Vector:
    """Return the nominal wheel radius of each group in the prediction of an estimator, shape (groups,) [m]."""
    model, names = model_of_estimator(estimator, train).model, states(estimator, train)
    values = {variable.name: variable.start for variable in model.parameters}
    return np.array([radius_of(values, g) for g in range(sum(name.startswith("wheelset_speed[") for name in names))])


def states(estimator: str = "", train: str = "") -> tuple[str, ...]:
    """Return the names of the states of an estimator's prediction."""
    return _prediction_of(estimator, train).states


def _task(case: RecordingCase, estimator: str, noise: NoiseSet) -> tuple[FilterContext, FilterData]:
    """Return model, noises and first belief for an estimator, and the data of its steps."""
    prediction = _prediction_of(estimator, case.train)
    model = model_of_estimator(estimator, case.train)
    process, readings = noise.process_noise(prediction.states), noise.reading_noise(prediction.outputs)
    start = noise.start_covariance(prediction.states)
    values = {variable.name: variable.start for variable in model.model.states} | model.start({})
    if is_fmu(estimator):
        values |= _own_prediction(estimator)[1]
    settings = Settings(
        process=dict(zip(prediction.states, process, strict=True)),
        readings=dict(zip(prediction.outputs, readings, strict=True)),
        start={state: values[state] for state in prediction.states if ElementName.of(state).array not in READ_STATES},
        start_deviation=dict(zip(prediction.states, np.sqrt(start), strict=True)),
    )
    data = filter_data(recording_of_case(case), prediction, settings)
    context = replace(
        context_of(prediction, settings, data),
        gate=pad_gate(model.release_pressure({}, RELEASED_PADS), case.groups),
        outlier_limit=[OUTLIER_LIMITS.get(ElementName.of(name).array, math.inf) for name in prediction.outputs],
    )
    return context, data


def replay(case: RecordingCase, estimator: str, noise: NoiseSet | None = None) -> FilterRun:
    """Return the estimates of one of `ESTIMATORS`, another kind of `railgrip.estimators.filters`, or an FMU.

    Args:
        case: The recording.
        estimator: Name of the estimator.
        noise: Its noises; None for those of `railgrip.studies.estimators.replay`.

    Raises:
        FilterDiverged: The filter diverged.
        ScenarioError: The kind does not exist.
    """
    context, data = _task(case, estimator, noise_of(estimator, case.sensors) if noise is None else noise)
    entry = entry_of(estimator)
    if entry.later != 0:
        found = _smoothed(context, data, entry.later)
    else:
        is_kind = entry.model == MODEL and not is_fmu(estimator)
        found = run_kind(estimator if is_kind else "fmu", context, data)
    if found.ended:
        raise FilterDiverged(found.ended)
    model = model_of_estimator(estimator, case.train)
    recording, names = recording_of_case(case), context.prediction.states
    effect = effect_of(context.prediction, data)
    variance = with_unmodelled(recording, names, found.mean, found.variance, case.sensors, model, effect)
    return replace(found, variance=variance)


def effect_of(prediction: PredictionInC, data: FilterData) -> Vector:
    """Return ∂(dω/dt)/∂α of each group at the start [rad/s²], shape (groups,)."""
    wheels, adhesions = columns(prediction.states, "wheelset_speed"), columns(prediction.states, "group_adhesion")
    return prediction.derivative_jacobian(data.mean, data.inputs[0])[wheels, adhesions]


def _smoothed(context: FilterContext, data: FilterData, lag: int | None) -> FilterRun:
    filter_ = ExtendedKalmanFilter.without_estimate(context)
    begin = process_time()
    found = smooth(filter_, filter_.start(data.mean, data.covariance), data.inputs, data.readings, lag)
    time = 1e6 * (process_time() - begin) / len(data.readings)
    return FilterRun(mean=found.mean, variance=np.einsum("kii->ki", found.covariance), microseconds=time)


@lru_cache(maxsize=16)  # every estimator of a case is judged by it
def bound_of(case: RecordingCase) -> Matrix:
    """Return the posterior Cramér-Rao bound of the variance of each state over a recording, shape (k + 1, n).

    It is that of the prediction linearised along the true states, with the noises of `fmu` and without its gate. Track
    force and bias, which enter the prediction linearly, are 0 there. The first row has the variances of the start.
    """
    context, data = _task(case, "fmu", noise_of("fmu", case.sensors))
    recording = recording_of_case(case)
    columns = [truth_of(recording, name) if knows(recording, name) else None for name in context.prediction.states]
    truth: Array = np.column_stack([np.zeros(recording.sizes["time"]) if one is None else one for one in columns])
    return bound_along(context, data, truth)


def bound_along(context: FilterContext, data: FilterData, truth: Matrix) -> Matrix:
    """Return the posterior Cramér-Rao bound of each variance along true states, shape (k, n); without the gate."""
    bound = posterior_bound(
        context.prediction,
        context.process_noise,
        context.reading_noise,
        context.period,
        context.covariance,
        truth[np.newaxis],
        data.inputs,
        np.isfinite(data.readings),
    )
    return np.einsum("kii->ki", bound)


def with_estimates(case: RecordingCase, estimator: str, run: FilterRun) -> xarray.Dataset:
    """Return the recording of a case with the estimates of a run as a trace has them, for `railgrip.trace.measures`.

    Slip is 1 − rω/v of the estimated speeds, with the nominal radius r of each group.
    """
    names, radius, deviation = states(estimator, case.train), _radii(estimator, case.train), np.sqrt(run.variance)
    speed, wheels, adhesions, pads = (
        columns(names, state) for state in ("speed", "wheelset_speed", "group_adhesion", "pad_friction")
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = radius * run.mean[:, wheels] / run.mean[:, speed]
        of_slip = np.hypot(radius * deviation[:, wheels], ratio * deviation[:, speed]) / run.mean[:, speed]
    groups = ("time", "group")
    return recording_of_case(case).assign(
        estimate_speed=("time", run.mean[:, speed[0]]),
        estimate_speed_sd=("time", deviation[:, speed[0]]),
        estimate_adhesion=(groups, run.mean[:, adhesions]),
        estimate_adhesion_sd=(groups, deviation[:, adhesions]),
        estimate_pad_friction=(groups, run.mean[:, pads]),
        estimate_pad_friction_sd=(groups, deviation[:, pads]),
        estimate_slip=(groups, 1.0 - ratio),
        estimate_slip_sd=(groups, np.abs(of_slip)),
    )


def columns(names: Sequence[str], state: str) -> list[int]:
    """Return the indices of the elements of a state among the names of states."""
    return [index for index, name in enumerate(names) if ElementName.of(name).array == state]
