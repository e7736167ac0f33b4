"""Commands for estimates: recordings and the states that they determine, the instrumented car, the monitor of pads."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, Literal

import typer
import xarray

from railgrip.base.errors import EstimationError, InputError
from railgrip.base.files import write_bytes, write_text
from railgrip.base.records import adopt, claim, require_free
from railgrip.base.tables import JsonObject
from railgrip.cli.app import AsJson, ImportFrom, Overrides, complete, fail, print_json
from railgrip.cli.library import write_schema
from railgrip.estimation.inspection import inspect_recording
from railgrip.estimation.judgement import Judgement, judge
from railgrip.estimation.models import units_of
from railgrip.estimation.results import errors_table, estimate_page, observe, parameters_table, with_estimates_as_truth
from railgrip.estimation.sources import recording_of_estimation
from railgrip.estimation.spec import (
    ModelParameter,
    Specification,
    estimate_of,
    load_specification,
    model_parameters,
    prediction_for,
    settings_with_origins,
)
from railgrip.recording.samples import knows
from railgrip.report.console import complain, progress, remark, say, show_table
from railgrip.report.figures import information
from railgrip.report.style import save
from railgrip.report.table import Form, ReportTable

OUT = Path("build/estimate")

File = Annotated[
    Path,
    typer.Argument(
        metavar="ESTIMATION",
        autocompletion=complete("estimations"),
        help="An estimation: a file (*.toml), or a name from railgrip list, such as wagon.",
    ),
]
Out = Annotated[Path | None, typer.Option(help="Folder for the results; build/estimate/NAME unless given.")]
Scenario = Annotated[str | None, typer.Option(help="Scenario to use instead of that of the estimation.")]
Seed = Annotated[int | None, typer.Option(min=0, help="Seed of the scenario; its own unless given.")]
TrainName = Annotated[
    str | None,
    typer.Option(
        metavar="TRAIN",
        autocompletion=complete("trains"),
        help="Train of the prediction, a name from railgrip list or a train file; for an estimation such as train.",
    ),
]
Data = Annotated[
    Path | None,
    typer.Option(metavar="RUN", help="Trace of a stop (.nc), or csv, parquet, mat, mf4 or mdf file, read by [data]."),
]


def observability(
    file: File,
    overrides: Overrides = None,
    out: Out = None,
    scenario: Scenario = None,
    seed: Seed = None,
    data: Data = None,
    import_from: ImportFrom = None,
) -> None:
    """Show which states a recording determines.

    The model is linearised along the true states where they are known, otherwise along the estimates of the filter.
    """
    specification = load_specification(file, overrides or [])
    files = ("observability.csv", "observability.png")
    folder = _folder(out, OUT / specification.name, files)
    recording = _recording(specification, data=data, scenario=scenario, seed=seed, import_from=import_from or ())
    _print_recording(recording)
    for sentence in recording.attrs.get("warnings", ()):
        complain(sentence)
    if data is not None:
        with progress(specification.name, "filter"):
            recording = with_estimates_as_truth(specification, recording)
    with progress(specification.name, "windows"):
        points, windows = observe(specification, recording)
    ranks = [
        {
            "at": f"{time:.2f} s, {what}",
            "rank": f"{result.rank} of {len(result.states)}",
            "derivatives": result.order,
            "not determined": ", ".join(result.undetermined) or "–",
        }
        for what, time, result in points
    ]
    show_table(ReportTable(ranks, left=("at", "not determined"), title="Rank of the readings and their derivatives"))
    claim(folder, *files)
    _write_windows(windows, folder / "observability.csv")
    gate = specification.gate
    inputs = tuple(gate.inputs) if gate is not None else prediction_for(specification).inputs[:2]
    picture = information(recording, windows, folder / "observability.png", inputs=inputs)
    say(f"{folder}/observability.csv, {picture}")


def estimate(
    file: File,
    overrides: Overrides = None,
    out: Out = None,
    scenario: Scenario = None,
    seed: Seed = None,
    data: Data = None,
    train: TrainName = None,
    import_from: ImportFrom = None,
    as_json: AsJson = False,
) -> None:
    """Run the filter of an estimation over its recording."""
    specification = load_specification(file, [*_of_train(train), *(overrides or [])])
    files = ("estimates.nc", "estimates.png", "index.html", "parameters.csv", "settings.csv")
    folder = _folder(out, OUT / specification.name, files)
    recording = _recording(specification, data=data, scenario=scenario, seed=seed, import_from=import_from or ())
    with progress(specification.name, "filter"):
        estimates = estimate_of(specification, recording)
    warnings, problems = (str(estimates.attrs[key]).splitlines() for key in ("warnings", "problems"))
    parameters = model_parameters(specification)
    states = [str(state) for state in estimates["state"].values]
    judgements = {state: judge(recording, estimates, state) for state in states if knows(recording, state)}
    with progress(specification.name, "page"):
        page = estimate_page(specification, recording, estimates, judgements, problems).write(folder)
        claim(folder, *files)
        write_bytes(folder / "estimates.nc", bytes(estimates.to_netcdf(engine="h5netcdf")))
    settings = settings_with_origins(specification, estimates)
    if as_json:
        print_json(
            {
                "estimation": specification.name,
                "recording": recording.attrs["name"],
                "repairs": list(recording.attrs.get("flags", ())),
                "warnings": warnings,
                "problems": problems,
                "nis_ratio": estimates.attrs["nis_ratio"],
                "parameters": [_as_json(each) for each in parameters],
                "settings": [_as_json(each) for each in settings],
                "states": _last_estimates(specification, estimates),
                "errors": {state: asdict(judgement) for state, judgement in judgements.items()},
                "files": [str(folder / "estimates.nc"), str(folder / "estimates.png")],
                "page": str(page),
            }
        )
    else:
        _print_recording(recording)
        _show_parameters(specification, parameters, is_users=data is not None)
        _print_errors(recording, estimates, judgements)
        say(f"{folder}/estimates.nc, {page}")
    for sentence in warnings:
        complain(sentence)
    if problems:
        fail(*(f"{specification.name}: {sentence}" for sentence in problems))


def inspect(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A recording: csv, parquet, mat, mf4 or mdf.")],
    estimation: Annotated[
        Path,
        typer.Option(
            "--for",
            metavar="ESTIMATION",
            autocompletion=complete("estimations"),
            help="Estimation that will read it: a file or a name from railgrip list.",
        ),
    ] = Path("field"),
    train: TrainName = None,
    time: Annotated[str | None, typer.Option(metavar="COLUMN", help="Column of time; recognised unless given.")] = None,
    decimal: Annotated[
        Literal[".", ","] | None,
        typer.Option(metavar="SIGN", help="Decimal sign of a csv file, . or ,; found unless given."),
    ] = None,
    order: Annotated[
        Literal["day-first", "month-first"] | None,
        typer.Option(metavar="ORDER", help="Order of dates such as 04/01/2025, day-first or month-first."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="File for the proposal (.toml), which must not exist; printed unless given.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Show what a recording holds, and propose its [data].

    The proposal lists the data of the vehicle that the model needs.
    """
    if out is not None and out.exists():
        raise InputError(f"{out} exists; choose another file.")
    dates = None if order is None else "day first" if order == "day-first" else "month first"
    inspection = inspect_recording(run, estimation, time, decimal, train, dates)
    if out is not None:
        write_text(out, f"#:schema ./estimation.schema.json\n{inspection.proposal}")
        write_schema("estimation", out)
    if as_json:
        print_json(
            {
                "columns": [asdict(finding) for finding in inspection.findings],
                "texts": inspection.texts,
                "signals": dict(inspection.signals),
                "unrecognised": inspection.unrecognised,
                "parameters": [_as_json(each) for each in inspection.parameters],
                "proposal": inspection.proposal,
                "notices": inspection.notices,
            }
        )
        return
    rows = [
        {
            "column": finding.name,
            "signal": next((signal for signal, name in inspection.signals.items() if name == finding.name), "–"),
            "unit": finding.unit or "–",
            "samples": finding.samples,
            "period [ms]": 1e3 * finding.period,
            "from [s]": finding.begin,
            "to [s]": finding.end,
            "least": finding.low,
            "largest": finding.high,
            "gaps": len(finding.gaps) or "–",
            "longest [s]": max((length for _, length in finding.gaps), default=math.nan),
        }
        for finding in inspection.findings
    ]
    forms: dict[str, Form] = dict.fromkeys(("period [ms]", "least", "largest", "longest [s]"), "{:.4g}")
    forms |= dict.fromkeys(("from [s]", "to [s]"), "{:.3f}")
    show_table(ReportTable(rows, forms, left=("column", "signal", "unit"), title=run.name))
    if inspection.texts:
        say(f"Columns without two numbers: {', '.join(inspection.texts)}.")
    for sentence in inspection.notices:
        complain(sentence)
    if out is None:
        say(inspection.proposal)
    else:
        _show_parameters(load_specification(out), inspection.parameters, is_users=True)
        say(f"{out}; continue with: railgrip estimate {out} --data {run}")
    if inspection.unrecognised:
        remark(f"Fill in what was not recognised: {', '.join(inspection.unrecognised)}.")


def _folder(out: Path | None, usual: Path, files: Sequence[str]) -> Path:
    """Return the folder for these files, which may be written there."""
    folder = out or usual
    if out is None:
        adopt(folder, *files)
    require_free(folder, *files)
    return folder


def _of_train(train: str | None) -> list[str]:
    return [] if train is None else [f"model.train={json.dumps(train)}"]


def _recording(specification: Specification, **source: Any) -> xarray.Dataset:
    with progress(specification.name, "recording"):
        return recording_of_estimation(specification, **source)


def _print_recording(recording: xarray.Dataset) -> None:
    for sentence in recording.attrs.get("flags", ()):
        say(f"{recording.attrs['name']}: {sentence}")


def _show_parameters(specification: Specification, parameters: Sequence[ModelParameter], *, is_users: bool) -> None:
    # A default matters only if the recording is of the user's vehicle, not of a simulated stop.
    show_table(parameters_table(parameters, f"Parameters of {specification.model.prediction.name}"))
    defaults = sum(each.is_default for each in parameters)
    if defaults and is_users:
        remark(
            f"{defaults} of {len(parameters)} parameters are library defaults: give the values of your vehicle in "
            "[model.parameters]."
        )


def _as_json(parameter: ModelParameter) -> JsonObject:
    return asdict(parameter) | {"is_default": parameter.is_default}


def _last_estimates(specification: Specification, estimates: xarray.Dataset) -> list[JsonObject]:
    units = units_of(specification.model.prediction.model)
    mean, sd = (estimates[name].values[-1] for name in ("mean", "sd"))
    names = [str(state) for state in estimates["state"].values]
    return [
        {"state": name, "unit": units[name] or "1", "mean": float(mean[i]), "sd": float(sd[i])}
        for i, name in enumerate(names)
    ]


def _print_errors(recording: xarray.Dataset, estimates: xarray.Dataset, judgements: Mapping[str, Judgement]) -> None:
    say(
        f"{recording.attrs['name']}: median NIS is {estimates.attrs['nis_ratio']:.3g} of the expected value; "
        "above 1 the filter is overconfident."
    )
    if judgements:
        show_table(errors_table(judgements, f"{recording.attrs['name']}: estimate minus truth"))


def _write_windows(windows: xarray.Dataset, path: Path) -> None:
    states = [str(state) for state in windows["state"].values]
    columns = ["time_s", "smallest", *(f"singular_{s}" for s in states), *(f"deviation_{s}" for s in states)]
    parts = (windows[name].values for name in ("time", "smallest", "singular", "deviation"))
    rows = [[f"{value:.6g}" for part in row for value in part.ravel()] for row in zip(*parts, strict=True)]
    ReportTable.of(columns, rows).write_csv(path)


RIDE_FILES = ("ride.nc", "ride.png")
"""Files that `railgrip ride` writes."""


def ride(
    file: Annotated[Path, typer.Argument(metavar="FILE.toml", help="A ride: car, run, and estimator.")],
    out: Annotated[
        Path | None, typer.Option(help="Folder for trace and figure; build/rides/NAME unless given.")
    ] = None,
) -> None:
    """Run the instrumented car with a trained friction estimator."""
    # Imported here, as below: the other commands need no study.
    from railgrip.estimation.axle_box.ride import read_ride, ride_figure, ride_with_estimator

    specification = read_ride(file)
    folder = _folder(out, Path("build/rides") / specification.name, RIDE_FILES)
    with progress(specification.name, "preparing", 1.0) as bar:
        trace, apart = ride_with_estimator(
            specification, file.parent, lambda share: bar.update(phase="ride", amount=share), remark
        )
    claim(folder, *RIDE_FILES)
    write_bytes(folder / "ride.nc", bytes(trace.to_netcdf(engine="h5netcdf")))
    save(ride_figure(trace), folder / "ride.png")
    last = trace.isel(time=-1)
    sentence = f"{specification.name}: after {float(last['time']):.1f} s friction {float(last['friction']):.3f}"
    if float(last["friction_sd"]) > 0:
        sentence += f" ± {float(last['friction_sd']):.3f}"
    sentence += f", true {specification.car.friction:.3f} in the mean"
    if apart is not None:
        sentence += f"; sample by sample within {apart:.1e} of the same readings at once"
    say(sentence)
    say(f"{folder}/ride.nc")


def monitor(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder of stops, which are read in the order of their names.")
    ],
    column_map: Annotated[
        Path | None, typer.Option("--map", metavar="FILE.toml", help="Estimation whose [data] maps recorded files.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Figure; DIR/monitor.png unless given.")] = None,
) -> None:
    """Follow the pad friction of each brake group from stop to stop."""
    from railgrip.studies.pad_monitor.watch import MonitorDesign, draw, health_table, stops_in, summary_of, watch

    with progress("monitor", "reading stops", is_count=True) as bar:
        evidence, sentences = stops_in(
            folder,
            None if column_map is None else load_specification(column_map),
            lambda number, of: bar.update(amount=number, total=of),
        )
    for sentence in sentences:
        say(sentence)
    if not evidence:
        raise EstimationError(f"{folder}: none of its stops can be used.")
    design = MonitorDesign()
    history = watch(list(evidence.values()), design)
    show_table(health_table(history, list(evidence)))
    say(summary_of(history, design))
    say(str(save(draw(history, design), out or folder / "monitor.png")))
