"""Estimates from recordings, and the states that a recording determines."""

import math
from pathlib import Path
from typing import Annotated, Any

import typer
import xarray

from railgrip.base.errors import InputError
from railgrip.base.files import write_bytes, write_text
from railgrip.base.outputs import adopt, claim, require_free
from railgrip.cli.app import ImportFrom, Overrides, complete, fail
from railgrip.cli.library import write_schema
from railgrip.estimation.inspection import inspect_recording
from railgrip.estimation.judge import judge
from railgrip.estimation.observable import observe, with_estimates_as_truth
from railgrip.estimation.plausible import strange_estimates, strange_signals
from railgrip.estimation.sources import recording_of_estimation
from railgrip.estimation.spec import Specification, estimate_of, load_specification, prediction_for
from railgrip.report.console import progress, remark, say, show_table
from railgrip.report.estimation import estimated, information
from railgrip.report.table import Form, Table, share
from railgrip.trace.samples import knows

OUT = Path("build/estimate")

File = Annotated[
    Path,
    typer.Argument(
        metavar="ESTIMATION",
        autocompletion=complete("estimations"),
        help="An estimation: a file (*.toml), or the name of one of ours, such as wagon.",
    ),
]
Out = Annotated[Path | None, typer.Option(help="Folder for the results; build/estimate/NAME unless given.")]
Scenario = Annotated[str | None, typer.Option(help="Another scenario of the same source.")]
Seed = Annotated[int | None, typer.Option(min=0, help="Of the source; the scenario's own unless given.")]
Data = Annotated[
    Path | None,
    typer.Option(metavar="RUN", help="Trace of a stop (.nc), or csv, parquet, mat or mf4 file, read by [data]."),
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
    folder = out or OUT / specification.name
    files = ("observability.csv", "observability.png")
    if out is None:
        adopt(folder, *files)
    require_free(folder, *files)
    recording = _recording(specification, data=data, scenario=scenario, seed=seed, import_from=import_from or ())
    if data is not None:
        with progress(f"{specification.name}: filter"):
            recording = with_estimates_as_truth(specification, recording)
    with progress(f"{specification.name}: windows"):
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
    show_table(Table(ranks, left=("at", "not determined"), title="Rank of the readings and their derivatives"))
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
    import_from: ImportFrom = None,
) -> None:
    """Run the filter of an estimation over its recording."""
    specification = load_specification(file, overrides or [])
    folder = out or OUT / specification.name
    files = ("estimates.nc", "estimates.png")
    if out is None:
        adopt(folder, *files)
    require_free(folder, *files)
    recording = _recording(specification, data=data, scenario=scenario, seed=seed, import_from=import_from or ())
    with progress(f"{specification.name}: filter"):
        prediction = prediction_for(specification)
        estimates = estimate_of(specification, recording)
    claim(folder, *files)
    write_bytes(folder / "estimates.nc", bytes(estimates.to_netcdf(engine="h5netcdf")))
    _print_errors(recording, estimates)
    strange = strange_signals(recording, (*prediction.inputs, *prediction.outputs)) + strange_estimates(estimates)
    with progress(f"{specification.name}: figure"):
        picture = estimated(recording, estimates, prediction.inputs, folder / "estimates.png")
    say(f"{folder}/estimates.nc, {picture}")
    problems = [*strange, *([estimates.attrs["ended"]] if estimates.attrs["ended"] else [])]
    if problems:
        fail(*(f"{specification.name}: {sentence}" for sentence in problems))


def inspect(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A recording: csv, parquet, mat or mf4.")],
    estimation: Annotated[
        Path,
        typer.Option(
            "--for",
            metavar="ESTIMATION",
            autocompletion=complete("estimations"),
            help="Estimation that is to read it: a file or one of ours.",
        ),
    ] = Path("field"),
    time: Annotated[str | None, typer.Option(metavar="COLUMN", help="Column of time; recognised unless given.")] = None,
    out: Annotated[
        Path | None, typer.Option(help="File for the proposal (.toml), which must not exist; printed unless given.")
    ] = None,
) -> None:
    """Show what a recording holds, and propose its [data]."""
    if out is not None and out.exists():
        raise InputError(f"{out} is already there; name another file.")
    inspection = inspect_recording(run, estimation, time)
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
    show_table(Table(rows, forms, left=("column", "signal", "unit"), title=run.name))
    if inspection.texts:
        say(f"Not numbers: {', '.join(inspection.texts)}.")
    if out is None:
        say(inspection.proposal)
    else:
        write_text(out, f"#:schema ./estimation.schema.json\n{inspection.proposal}")
        write_schema("estimation", out)
        say(f"{out}; go on with: railgrip estimate {out} --data {run}")
    if inspection.unrecognised:
        remark(f"Fill in what was not recognised: {', '.join(inspection.unrecognised)}.")


def _recording(specification: Specification, **source: Any) -> xarray.Dataset:
    """Return the recording of an estimation, see `recording_of_estimation`; print what was mended in a user's file."""
    with progress(f"{specification.name}: recording"):
        recording = recording_of_estimation(specification, **source)
    for sentence in recording.attrs.get("flags", ()):
        say(f"{recording.attrs['name']}: {sentence}")
    return recording


def _print_errors(recording: xarray.Dataset, estimates: xarray.Dataset) -> None:
    """Print how far off each state was whose truth is known."""

    say(
        f"{recording.attrs['name']}: median NIS is {estimates.attrs['nis_ratio']:.3g} of the expected one; above 1 the "
        "filter is surer than its readings allow."
    )
    states = [str(state) for state in estimates["state"].values if knows(recording, str(state))]
    if not states:
        return
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
        for state in states
        for judgement in (judge(recording, estimates, state),)
    ]
    forms: dict[str, Form] = {
        **dict.fromkeys(("rmse", "of the best constant", "largest"), "{:.4g}"),
        "bias": "{:+.4g}",
        "NEES": "{:.3g}",
        "within 2 sd": share,
    }
    show_table(Table(rows, forms, title=f"{recording.attrs['name']}: estimate minus truth"))


def _write_windows(windows: xarray.Dataset, path: Path) -> None:
    """Write smallest singular values and deviations as CSV, a row a window."""
    states = [str(state) for state in windows["state"].values]
    columns = ["time_s", "smallest", *(f"singular_{s}" for s in states), *(f"deviation_{s}" for s in states)]
    parts = (windows[name].values for name in ("time", "smallest", "singular", "deviation"))
    rows = [[f"{value:.6g}" for part in row for value in part.ravel()] for row in zip(*parts, strict=True)]
    Table.of(columns, rows).write_csv(path)
