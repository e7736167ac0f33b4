"""Estimators over a recording: every one gets the same inputs and readings, through the same prediction FMU."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from pathlib import Path
from time import process_time
from typing import Final

import numpy as np
import xarray

from railgrip.base.errors import FilterDiverged, InputError
from railgrip.base.names import ElementName, state_name
from railgrip.estimation.models import PredictionModel, of_class, of_train
from railgrip.estimation.run import READ_STATES, FilterData, Settings, by_name, filter_data
from railgrip.estimation.several import run_kind
from railgrip.estimators.belief import Array, Matrix, Vector
from railgrip.estimators.consistency import nis_ratio
from railgrip.estimators.design import FilterContext
from railgrip.estimators.ekf import ExtendedKalmanFilter
from railgrip.estimators.observability import posterior_bound
from railgrip.estimators.prediction import PredictionInC
from railgrip.estimators.smoother import smooth
from railgrip.estimators.tuning import NoiseSet, pad_gate
from railgrip.fmi import FmuPrediction, describe
from railgrip.recording.samples import knows, truth_of
from railgrip.scenario.file import NamedFile, locate
from railgrip.simulate.estimator import RELEASED_PADS
from railgrip.simulate.train_prediction import radius_of
from railgrip.studies.estimators.claims import with_unmodelled
from railgrip.studies.estimators.noises import OUTLIER_LIMITS, noise_of
from railgrip.studies.estimators.own import is_fmu
from railgrip.studies.estimators.recordings import RecordingCase, recording_of_case

MODEL: Final = "TrainPredictionReducedDisturbed"
"""Prediction of all estimators but those of `OTHER_MODELS`: 15 states, so that a step in numpy takes milliseconds."""

OTHER_MODELS: Final = {
    "reduced": "TrainPredictionReduced",
    "disturbed": "TrainPredictionDisturbed",
    "loaded": "TrainPredictionLoaded",
}
"""Extended Kalman filters on other predictions: without track force and bias, with suspension, with load too."""

OF_TRAINS: Final = {
    "fmu": ("ConsistPredictionDisturbed", False),
    "reduced": ("ConsistPrediction", False),
    "disturbed": ("ConsistPredictionDisturbed", True),
}
"""The same for a train file: class, and whether it has the suspension."""

LAGS: Final[dict[str, int | None]] = {"smoother": None, "fixed_lag": 10}
"""Offline estimators → number of later samples that they use; None for all."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Replay:
    """Estimates at every sample of a recording.

    Attributes:
        mean: Shape (k + 1, n), in the order of the prediction's states; the first row is the start.
        variance: Variance of each state, errors in no equation included, shape (k + 1, n).
        nis_ratio: Median of the normalised innovation squared over its expected one; None without innovations.
        microseconds: Processor time of a step [µs].
    """

    mean: Matrix
    variance: Matrix
    nis_ratio: float | None
    microseconds: float


def model_of_estimator(estimator: str, train: str = "") -> PredictionModel:
    """Return the prediction model of an estimator on board of a train, or of the two-part train for an empty name.

    Those of other trains are `ConsistPredictionDisturbed`, for `disturbed` with the suspension, and for `reduced`
    `ConsistPrediction`.

    Raises:
        InputError: The estimator has no prediction for a train file.
    """
    if not train:
        return of_class(OTHER_MODELS.get(estimator, MODEL))
    if estimator not in (*OTHER_MODELS, *OF_TRAINS):
        estimator = "fmu"
    if estimator not in OF_TRAINS:
        raise InputError(f"{estimator} has no prediction for a train file; leave out --train, or this estimator.")
    class_name, has_suspension = OF_TRAINS[estimator]
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
    own = is_fmu(estimator)
    return _own_prediction(estimator)[0] if own else _prediction(estimator if estimator in OTHER_MODELS else "", train)


def radii(estimator: str, train: str) -> Vector:
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
    context = FilterContext(
        prediction=prediction,
        process_noise=by_name("process", settings.process, prediction.states),
        reading_noise=by_name("readings", settings.readings, prediction.outputs),
        period=data.step,
        gate=pad_gate(model.release_pressure({}, RELEASED_PADS), case.groups),
        outlier_limit=[OUTLIER_LIMITS.get(ElementName.of(name).array, math.inf) for name in prediction.outputs],
        mean=data.mean,
        covariance=data.covariance,
    )
    return context, data


def replay(case: RecordingCase, estimator: str, noise: NoiseSet | None = None) -> Replay:
    """Return the estimates of a kind of `railgrip.estimators.filters`, of `LAGS`, `OTHER_MODELS`, or an FMU.

    Args:
        case: The recording.
        estimator: Name of the estimator.
        noise: Its noises; None for those of `railgrip.studies.estimators.noises`.

    Raises:
        FilterDiverged: The filter diverged.
        ScenarioError: The kind does not exist.
    """
    context, data = _task(case, estimator, noise_of(estimator, case.sensors) if noise is None else noise)
    if estimator in LAGS:
        found = _smoothed(context, data, LAGS[estimator])
    else:
        is_kind = estimator not in OTHER_MODELS and not is_fmu(estimator)
        found = _filtered(context, data, estimator if is_kind else "fmu")
    model = model_of_estimator(estimator, case.train)
    recording, names = recording_of_case(case), context.prediction.states
    effect = effect_of(context.prediction, data)
    variance = with_unmodelled(recording, names, found.mean, found.variance, case.sensors, model, effect)
    return replace(found, variance=variance)


def effect_of(prediction: PredictionInC, data: FilterData) -> Vector:
    """Return ∂(dω/dt)/∂α of each group at the start [rad/s²], shape (groups,)."""
    wheels, adhesions = columns(prediction.states, "wheelset_speed"), columns(prediction.states, "group_adhesion")
    return prediction.derivative_jacobian(data.mean, data.inputs[0])[wheels, adhesions]


def _filtered(context: FilterContext, data: FilterData, kind: str) -> Replay:
    run = run_kind(kind, context, data)
    if run.ended:
        raise FilterDiverged(run.ended)
    nis = run.squared_innovation
    return Replay(
        mean=run.mean,
        variance=run.variance,
        nis_ratio=nis_ratio(nis, run.degrees) if nis.any() else None,
        microseconds=run.microseconds,
    )


def _smoothed(context: FilterContext, data: FilterData, lag: int | None) -> Replay:
    filter_ = ExtendedKalmanFilter.without_estimate(context)
    begin = process_time()
    found = smooth(filter_, filter_.start(data.mean, data.covariance), data.inputs, data.readings, lag)
    return Replay(
        mean=found.mean,
        variance=np.einsum("kii->ki", found.covariance),
        nis_ratio=None,
        microseconds=1e6 * (process_time() - begin) / len(data.readings),
    )


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


def with_estimates(recording: xarray.Dataset, names: Sequence[str], mean: Matrix, variance: Matrix) -> xarray.Dataset:
    """Return a recording with estimates of states as a trace has them, for `railgrip.trace.estimation`."""
    groups = ("time", "group")
    return recording.assign(
        estimate_speed=("time", mean[:, columns(names, "speed")[0]]),
        estimate_speed_sd=("time", np.sqrt(variance[:, columns(names, "speed")[0]])),
        estimate_adhesion=(groups, mean[:, columns(names, "group_adhesion")]),
        estimate_adhesion_sd=(groups, np.sqrt(variance[:, columns(names, "group_adhesion")])),
        estimate_pad_friction=(groups, mean[:, columns(names, "pad_friction")]),
        estimate_pad_friction_sd=(groups, np.sqrt(variance[:, columns(names, "pad_friction")])),
    )


def columns(names: Sequence[str], state: str) -> list[int]:
    """Return the indices of the elements of a state among the names of states."""
    return [index for index, name in enumerate(names) if ElementName.of(name).array == state]
