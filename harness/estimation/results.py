"""Results of an estimation besides its estimates: observability of the states, and the page.

Observability is the rank at points of a recording, and information over windows of it.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray

from railgrip.base.errors import EstimationError
from railgrip.base.groups import gather
from railgrip.base.names import ElementName
from railgrip.estimation.judgement import Judgement
from railgrip.estimation.models import units_of
from railgrip.estimation.run import by_name
from railgrip.estimation.spec import (
    ModelParameter,
    Specification,
    equations_for,
    estimate_of,
    model_parameters,
    settings_for,
    settings_with_origins,
)
from railgrip.estimators.belief import Matrix, Vector
from railgrip.estimators.observability import Observability, along, observability
from railgrip.recording.samples import knows, period_of, samples, truth_of, with_signals
from railgrip.report.figures import estimates_figure
from railgrip.report.page import Page
from railgrip.report.table import Form, ReportTable, share

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


def estimate_page(
    specification: Specification,
    recording: xarray.Dataset,
    estimates: xarray.Dataset,
    judgements: Mapping[str, Judgement],
    problems: Sequence[str],
) -> Page:
    """Return the page of estimates with their figure, `estimates.png`, and data, `estimates.nc`.

    Args:
        specification: The estimation.
        recording: Recording that the filter was run over.
        estimates: Result of `railgrip.estimation.spec.estimate_of`.
        judgements: Errors of the states whose true values are known.
        problems: Sentences about implausible signals and estimates.
    """
    model = specification.model.prediction
    parameters, settings = model_parameters(specification), settings_with_origins(specification, estimates)
    units = units_of(model.model)
    mean, sd = (estimates[name].isel(time=-1).values.tolist() for name in ("mean", "sd"))
    states = [str(state) for state in estimates["state"].values]
    last = [
        {"state": state, "estimate": mean[i], "standard deviation": sd[i], "unit": units[state] or "1"}
        for i, state in enumerate(states)
    ]
    tables = {"parameters.csv": parameters_table(parameters), "settings.csv": parameters_table(settings)}
    return Page(
        title=f"{specification.name}: estimates from {recording.attrs['name']}",
        question="What are adhesion, pad friction and speed, and which assumptions do they rest on?",
        answer=(
            f"The filter on the prediction of {model.name} has a median NIS of {estimates.attrs['nis_ratio']:.3g} "
            f"times the expected one. {estimates.attrs['ended'] or 'It followed the recording to its end.'}"
        ),
        template="report/estimation.md.jinja",
        values={
            "problems": problems,
            "last": ReportTable(last, dict.fromkeys(("estimate", "standard deviation"), "{:.4g}")),
            "errors": errors_table(judgements, ""),
            "model": model.name,
            "count": len(parameters),
            "defaults": sum(each.is_default for each in parameters),
            "parameters": tables["parameters.csv"],
            "settings": tables["settings.csv"],
        },
        figures={
            "estimates.png": estimates_figure(recording, estimates, [variable.name for variable in model.model.inputs])
        },
        tables=tables,
    )


def parameters_table(parameters: Sequence[ModelParameter], title: str = "") -> ReportTable:
    """Return parameters with value, unit and origin; elements of an array with the same origin are in one row."""
    rows = gather(((ElementName.of(each.name).array, each.origin), each) for each in parameters)
    table = [
        {
            "parameter": name if len(elements) > 1 else elements[0].name,
            "value": ", ".join(f"{each.value:g}" for each in elements),
            "unit": elements[0].unit,
            "origin": origin,
            "meaning": " ".join(elements[0].description.split()),
        }
        for (name, origin), elements in rows.items()
    ]
    return ReportTable(table, left=("parameter", "value", "unit", "origin", "meaning"), title=title)


def errors_table(judgements: Mapping[str, Judgement], title: str) -> ReportTable:
    """Return the errors of the states whose true values are known."""
    columns: dict[str, tuple[str, Form]] = {
        "rmse": ("rmse", "{:.4g}"), "of the best constant": ("constant", "{:.4g}"), "bias": ("bias", "{:+.4g}"),
        "largest": ("largest", "{:.4g}"), "NEES": ("nees", "{:.3g}"), "within 2 sd": ("coverage", share),
    }  # fmt: skip
    rows = [
        (state, *(getattr(judgement, figure) for figure, _ in columns.values()))
        for state, judgement in judgements.items()
    ]
    return ReportTable.of({"state": "", **{column: form for column, (_, form) in columns.items()}}, rows, title=title)
