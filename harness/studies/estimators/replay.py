"""Estimators over a recording: every one gets the same inputs and readings, through the same prediction FMU."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from time import process_time
from typing import Final

import numpy as np
import xarray

from railgrip.base import registry
from railgrip.estimation.run import READ_STATES, FilterData, Settings, by_name, filter_data, model_of, prediction_of
from railgrip.estimators.belief import Array, Matrix, Vector
from railgrip.estimators.consistency import nis_ratio
from railgrip.estimators.design import FilterContext, FilterKind
from railgrip.estimators.ekf import ExtendedKalmanFilter
from railgrip.estimators.observability import posterior_bound
from railgrip.estimators.smoother import smooth
from railgrip.estimators.tuning import NOISE_SETS, NoiseSet, pad_gate
from railgrip.recording.samples import truth_of
from railgrip.simulate.estimator import RELEASED_PADS
from railgrip.simulate.prediction import release_pressure
from railgrip.studies.estimators.recordings import GROUPS, RecordingCase, recording_of_case

MODEL: Final = "TrainPredictionReduced"
"""Prediction of all estimators but those of `OTHER_MODELS`: 13 states, so that a step in numpy takes milliseconds."""

OTHER_MODELS: Final = {"disturbed": "TrainPredictionDisturbed", "loaded": "TrainPredictionLoaded"}
"""Extended Kalman filters on other predictions: with track force and bias as states, and with the load too."""

LAGS: Final[dict[str, int | None]] = {"smoother": None, "fixed_lag": 10}
"""Offline estimators → number of later samples that they use; None for all."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Replay:
    """Estimates at every sample of a recording.

    Attributes:
        mean: Shape (k + 1, n), in the order of the prediction's states; the first row is the start.
        variance: Of each state, shape (k + 1, n).
        nis_ratio: Median of the normalised innovation squared over its expected one; None without innovations.
        microseconds: Processor time of a step [µs].
    """

    mean: Matrix
    variance: Matrix
    nis_ratio: float | None
    microseconds: float


_prediction = cache(prediction_of)


def states(estimator: str = "") -> tuple[str, ...]:
    """Return the names of the states of an estimator's prediction."""
    return _prediction(OTHER_MODELS.get(estimator, MODEL)).states


def _noise(case: RecordingCase, model: str) -> NoiseSet:
    """Return the noises of a prediction; those with disturbances have noises of service sensors only."""
    if model == MODEL:
        return NOISE_SETS["reduced_ideal" if case.sensors == "ideal" else "reduced_service"]
    return NOISE_SETS[f"{model.removeprefix('TrainPrediction').lower()}_service"]


def _task(case: RecordingCase, name: str = MODEL) -> tuple[FilterContext, FilterData]:
    """Return model, noises and first belief for an estimator, and the data of its steps."""
    prediction, model = _prediction(name), model_of(name)
    noise = _noise(case, name)
    process, readings = noise.process_noise(prediction.states), noise.reading_noise(prediction.outputs)
    start = noise.start_covariance(prediction.states)
    values = {variable.name: variable.start for variable in (*model.parameters, *model.states)}
    settings = Settings(
        process=dict(zip(prediction.states, process, strict=True)),
        readings=dict(zip(prediction.outputs, readings, strict=True)),
        start={state: values[state] for state in prediction.states if state.partition("[")[0] not in READ_STATES},
        start_deviation=dict(zip(prediction.states, np.sqrt(start), strict=True)),
    )
    data = filter_data(recording_of_case(case), prediction, settings)
    context = FilterContext(
        prediction=prediction,
        process_noise=by_name("process", settings.process, prediction.states),
        reading_noise=by_name("readings", settings.readings, prediction.outputs),
        period=data.period,
        gate=pad_gate(release_pressure(values, 0, RELEASED_PADS), GROUPS),
        outlier_limit=None,
        mean=data.mean,
        covariance=data.variance,
    )
    return context, data


def replay(case: RecordingCase, estimator: str) -> Replay:
    """Return the estimates of a kind of `railgrip.estimators.filters`, or of one of `LAGS` or `OTHER_MODELS`.

    Raises:
        FilterDiverged: The filter diverged.
        ScenarioError: The kind does not exist.
    """
    context, data = _task(case, OTHER_MODELS.get(estimator, MODEL))
    if estimator in LAGS:
        return _smoothed(context, data, LAGS[estimator])
    return _filtered(context, data, "fmu" if estimator in OTHER_MODELS else estimator)


def _filtered(context: FilterContext, data: FilterData, estimator: str) -> Replay:
    filter_ = registry.part(registry.FILTERS, estimator, FilterKind).start(context)
    count, n = data.readings.shape[0], data.mean.size
    mean, variance = np.empty((count + 1, n)), np.empty((count + 1, n))
    nis, degrees = np.empty(count), np.empty(count)
    mean[0], variance[0] = filter_.mean, np.diagonal(filter_.covariance)
    begin = process_time()
    for k in range(count):
        filter_.inputs[:], filter_.readings[:] = data.inputs[k], data.readings[k]
        filter_.advance()
        mean[k + 1], variance[k + 1] = filter_.mean, np.diagonal(filter_.covariance)
        nis[k], degrees[k] = filter_.squared_innovation, filter_.selection.sum()
    duration = process_time() - begin
    return Replay(
        mean=mean,
        variance=variance,
        nis_ratio=nis_ratio(nis, degrees) if nis.any() else None,
        microseconds=1e6 * duration / count,
    )


def _smoothed(context: FilterContext, data: FilterData, lag: int | None) -> Replay:
    filter_ = ExtendedKalmanFilter(
        context.prediction, context.process_noise, context.reading_noise, context.period, context.gate
    )
    begin = process_time()
    found = smooth(filter_, filter_.start(data.mean, data.variance), data.inputs, data.readings, lag)
    return Replay(
        mean=found.mean,
        variance=np.einsum("kii->ki", found.covariance),
        nis_ratio=None,
        microseconds=1e6 * (process_time() - begin) / len(data.readings),
    )


def bound_of(case: RecordingCase) -> Vector:
    """Return the posterior Cramér-Rao bound of each state as a root mean square over the recording, shape (n,).

    It is that of the prediction linearised along the true states, with its noises and without its gate.
    """
    context, data = _task(case)
    recording = recording_of_case(case)
    truth: Array = np.column_stack([truth_of(recording, name) for name in context.prediction.states])
    bound = posterior_bound(
        context.prediction,
        context.process_noise,
        context.reading_noise,
        context.period,
        np.diag(context.covariance),
        truth[np.newaxis],
        data.inputs,
        np.isfinite(data.readings),
    )
    return np.sqrt(np.mean(np.einsum("kii->ki", bound), axis=0))


def with_estimates(recording: xarray.Dataset, names: Sequence[str], mean: Matrix, variance: Matrix) -> xarray.Dataset:
    """Return a recording with estimates of states as a trace has them, for `railgrip.trace.estimation`."""

    def columns(state: str) -> list[int]:
        return [index for index, name in enumerate(names) if name.partition("[")[0] == state]

    groups = ("time", "group")
    return recording.assign(
        estimate_speed=("time", mean[:, columns("v")[0]]),
        estimate_speed_sd=("time", np.sqrt(variance[:, columns("v")[0]])),
        estimate_adhesion=(groups, mean[:, columns("alpha")]),
        estimate_adhesion_sd=(groups, np.sqrt(variance[:, columns("alpha")])),
        estimate_pad_friction=(groups, mean[:, columns("mu_b")]),
        estimate_pad_friction_sd=(groups, np.sqrt(variance[:, columns("mu_b")])),
    )
