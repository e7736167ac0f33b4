"""Several kinds of filters over the same recording."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import process_time

import numpy as np
import xarray

from railgrip.base import registry
from railgrip.base.errors import EstimationError, FilterDiverged
from railgrip.base.names import did_you_mean
from railgrip.estimation.run import FilterData, Settings, by_name, filter_data
from railgrip.estimators.belief import Matrix, Vector
from railgrip.estimators.design import FilterContext, FilterKind
from railgrip.estimators.prediction import PredictionInC


@dataclass(frozen=True, slots=True, kw_only=True)
class FilterRun:
    """Estimates of a filter at every sample of a recording of k steps, NaN from where it diverged.

    Attributes:
        mean, variance: Shape (k + 1, n), the start first.
        squared_innovation: Normalised innovation squared of each step, shape (k,).
        degrees: Number of readings of each step, shape (k,).
        ended: Sentence on where and why it diverged; empty if it did not.
        microseconds: Processor time of a step [µs].
    """

    mean: Matrix
    variance: Matrix
    squared_innovation: Vector
    degrees: Vector
    ended: str
    microseconds: float


def run_kind(kind: str, context: FilterContext, data: FilterData) -> FilterRun:
    """Return the estimates of a kind of `railgrip.estimators.filters`.

    Raises:
        EstimationError: The kind does not exist, or takes a train in parts.
    """
    known = [name for name in registry.modules(registry.FILTERS) if _kind(name).prediction != "parts"]
    if kind not in known:
        hint = did_you_mean(kind, known) or f"there are {', '.join(known)}."
        raise EstimationError(f"there is no filter '{kind}' for a recording; {hint}")
    filter_ = _kind(kind).start(context)
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
