"""Observability of the states of a prediction from a recording: rank at points, information over windows."""

import numpy as np
import xarray

from railgrip.base.errors import EstimationError
from railgrip.estimation.models import units_of
from railgrip.estimation.run import by_name
from railgrip.estimation.spec import Specification, equations_for, estimate_of, settings_for
from railgrip.estimators.belief import Matrix, Vector
from railgrip.estimators.observability import Observability, along, observability
from railgrip.recording.samples import knows, period_of, samples, truth_of, with_signals

Point = tuple[str, float, Observability]
"""A sample with its rank: the reason for its choice, its time [s], and rank, order and undetermined states."""


def observe(specification: Specification, recording: xarray.Dataset) -> tuple[list[Point], xarray.Dataset]:
    """Return points and windows of the observability of the states along their true values.

    Points are the sample with the largest input that opens the gate, and the same with that input at zero. Windows have
    `smallest` (time), the smallest singular value of the scaled observability Gramian of the window that begins there,
    `deviation` (time, state), the standard deviation of a state from that window alone, in its unit, and `singular`
    (time, state), the square of scale over deviation, 0 for a state without information.

    Inputs below the threshold of a gate are set to zero, as in the filter: they are noise of a released load cell.

    Raises:
        EstimationError: The file has no [observability], the recording lacks true states, or is shorter than a window.
    """
    table = specification.observability
    if table is None:
        raise EstimationError(
            f"{specification.name}: there is no [observability]; give scale, by state, window and stride."
        )
    prediction = equations_for(specification)
    period = period_of(recording)
    settings = settings_for(specification, period)
    unknown = [state for state in prediction.states if not knows(recording, state)]
    if unknown:
        raise EstimationError(
            f"observability: the recording has no true {', '.join(unknown)}; it needs a trajectory of all states, "
            "from a stop or as true_<state> from an estimate."
        )
    states = np.stack([truth_of(recording, state) for state in prediction.states], axis=1)
    inputs = samples(recording, prediction.inputs)
    gates: list[int] = []
    if settings.gate is not None:
        gates = [prediction.inputs.index(name) for name in settings.gate.inputs]
        inputs[:, gates] = np.where(inputs[:, gates] < settings.gate.threshold, 0.0, inputs[:, gates])
    scale = by_name("[observability] scale", table.scale, prediction.states)
    noise = by_name("[noise] readings", settings.readings, prediction.outputs)
    window, stride = max(round(table.window / period), 1), max(round(table.stride / period), 1)
    if window > len(states):
        raise EstimationError(
            f"[observability] window is {table.window:g} s, the recording has {len(states) * period:g} s; shorten it."
        )
    start, smallest, deviation = along(prediction, states, inputs, period, noise, scale, window, stride)
    time = recording["time"].values
    windows = xarray.Dataset(
        {
            "smallest": (("time",), smallest, {"units": "1"}),
            "deviation": (("time", "state"), deviation),
            "singular": (("time", "state"), (scale / deviation) ** 2, {"units": "1"}),
        },
        coords={"time": time[start], "state": list(prediction.states)},
        attrs={"window": table.window, "name": recording.attrs.get("name", "")},
    )
    points = [
        (what, float(time[k]), observability(prediction, states[k], values, scale))
        for what, k, values in _instants(prediction.inputs, inputs, gates)
    ]
    return points, windows


def _instants(names: tuple[str, ...], inputs: Matrix, gates: list[int]) -> list[tuple[str, int, Vector]]:
    deciding = gates or list(range(len(names)))
    most = int(np.argmax(np.min(inputs[:, deciding], axis=1))) if deciding else 0
    instants = [("inputs at their largest together", most, inputs[most])]
    for place in deciding:
        without = inputs[most].copy()
        without[place] = 0.0
        instants.append((f"the same, but no {names[place]}", most, without))
    return instants


def with_estimates_as_truth(specification: Specification, recording: xarray.Dataset) -> xarray.Dataset:
    """Return a recording with the estimates of the filter as its true states, the best available trajectory.

    Raises:
        EstimationError: The filter diverged.
    """
    estimates = estimate_of(specification, recording)
    if estimates.attrs["ended"]:
        raise EstimationError(f"{specification.name}: {estimates.attrs['ended']} There is no trajectory of the states.")
    units = units_of(specification.model.prediction.model)
    states = [str(state) for state in estimates["state"].values]
    return with_signals(recording, truth={s: (estimates["mean"].sel(state=s).values, units[s]) for s in states})
