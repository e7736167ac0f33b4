"""The page of an estimation: states, errors, and every parameter with its origin."""

from collections.abc import Mapping, Sequence

import xarray

from railgrip.base.names import ElementName
from railgrip.estimation.judge import Judgement
from railgrip.estimation.run import units_of
from railgrip.estimation.spec import ModelParameter, Specification, model_parameters, settings_with_origins
from railgrip.report.estimation import estimates_figure
from railgrip.report.page import Page
from railgrip.report.table import Form, ReportTable, share


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
    rows: dict[tuple[str, str], list[ModelParameter]] = {}
    for each in parameters:
        rows.setdefault((ElementName.of(each.name).array, each.origin), []).append(each)
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
    rows = [
        {
            "state": state,
            "rmse": judgement.rmse,
            "of the best constant": judgement.constant,
            "bias": judgement.bias,
            "largest": judgement.largest,
            "NEES": judgement.nees,
            "within 2 sd": judgement.coverage,
        }
        for state, judgement in judgements.items()
    ]
    forms: dict[str, Form] = {
        **dict.fromkeys(("rmse", "of the best constant", "largest"), "{:.4g}"),
        "bias": "{:+.4g}",
        "NEES": "{:.3g}",
        "within 2 sd": share,
    }
    return ReportTable(rows, forms, title=title)
