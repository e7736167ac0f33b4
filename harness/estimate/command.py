"""Commands of this room: observability, estimate and rig; `add_to` puts them on the command line."""

import csv
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.table import Table

from harness.interrupted import status

if TYPE_CHECKING:
    import xarray

# Where nobody watches, a table is not cut to a screen that is not there.
_out = Console(width=None if sys.stdout.isatty() else 140)
_err = Console(stderr=True)

OUT = Path("build/estimate")

File = Annotated[
    Path, typer.Argument(metavar="FILE.toml", help="An estimation; examples are in harness/estimate/library.")
]
Out = Annotated[Path | None, typer.Option(help="Folder for the results; build/estimate/NAME unless given.")]
Scenario = Annotated[str | None, typer.Option(help="Another scenario of the same source.")]
Seed = Annotated[int | None, typer.Option(min=0, help="Of the source; the scenario's own unless given.")]
Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="table.key=value", help="Change a value, as in model.parameters.T_mu='20 s'."),
]
Data = Annotated[
    Path | None, typer.Option(metavar="RUN", help="Recorded csv, parquet, mat or mf4 file, read by [data].")
]


def observability(
    file: File,
    overrides: Overrides = None,
    out: Out = None,
    scenario: Scenario = None,
    seed: Seed = None,
    data: Data = None,
) -> None:
    """Ask what the recording of an estimation can tell about each state, and plot it along the way.

    Along the true states where they are known, else, from recorded data, along those that the filter estimates.
    """
    from harness.estimate.observable import observe, with_estimates_as_truth
    from harness.estimate.sources import recording_of_estimation
    from harness.estimate.spec import load_specification, prediction_for
    from harness.verdict.observability import information

    specification = load_specification(file, overrides or [])
    folder = out or OUT / specification.name
    with status(_err, f"{specification.name}: recording"):
        recording = recording_of_estimation(specification, data=data, scenario=scenario, seed=seed)
    if data is not None:
        _say_flags(recording)
        with status(_err, f"{specification.name}: filter"):
            recording = with_estimates_as_truth(specification, recording)
    with status(_err, f"{specification.name}: windows"):
        observed = observe(specification, recording)
    table = Table(
        box=None, header_style="bold", title="Rank of the readings and their derivatives", title_justify="left"
    )
    for column in ("at", "rank", "derivatives", "not determined"):
        table.add_column(column)
    for point in observed.points:
        found = point.found
        table.add_row(
            f"{point.time:.2f} s, {point.what}",
            f"{found.rank} of {len(found.states)}",
            str(found.order),
            ", ".join(found.undetermined) or "-",
        )
    _out.print(table)
    windows = observed.windows
    _write_windows(windows, folder / "observability.csv")
    gate = specification.gate
    shown = tuple(gate.inputs) if gate is not None else prediction_for(specification).inputs[:2]
    picture = information(recording, windows, folder / "observability.png", inputs=shown)
    _out.print(f"{folder}/observability.csv, {picture}", highlight=False, soft_wrap=True)


def estimate(
    file: File,
    overrides: Overrides = None,
    out: Out = None,
    scenario: Scenario = None,
    seed: Seed = None,
    data: Data = None,
) -> None:
    """Run the filter of an estimation over its recording; write what it believes and how far off it was."""
    from harness.estimate.plausible import strange_estimates, strange_signals
    from harness.estimate.sources import recording_of_estimation
    from harness.estimate.spec import estimate_of, load_specification, prediction_for
    from harness.record.atomic import replacing
    from harness.verdict.estimated import estimated

    specification = load_specification(file, overrides or [])
    folder = out or OUT / specification.name
    with status(_err, f"{specification.name}: recording"):
        recording = recording_of_estimation(specification, data=data, scenario=scenario, seed=seed)
    _say_flags(recording)
    with status(_err, f"{specification.name}: filter"):
        prediction = prediction_for(specification)
        told = estimate_of(specification, recording)
    with replacing(folder / "estimates.nc") as partial:
        told.to_netcdf(partial, engine="h5netcdf")
    _print_errors(recording, told)
    strange = strange_signals(recording, (*prediction.inputs, *prediction.outputs)) + strange_estimates(told)
    with status(_err, f"{specification.name}: figure"):
        picture = estimated(recording, told, prediction.inputs, folder / "estimates.png")
    _out.print(f"{folder}/estimates.nc, {picture}", highlight=False, soft_wrap=True)
    problems = [*strange, *([told.attrs["ended"]] if told.attrs["ended"] else [])]
    for sentence in problems:
        _err.print(f"{specification.name}: {sentence}", style="red", highlight=False, markup=False, soft_wrap=True)
    if problems:
        raise typer.Exit(3)


def rig(out: Annotated[Path, typer.Option(help="Folder for figures and tables.")] = OUT / "rig") -> None:
    """Run the roller-rig tests of Schwarz and Keck (2020) with their filter and ours; write figures and tables."""
    from harness.estimate.rig import study

    with status(_err, "roller rig") as tell:
        rows = study(out, tell)
    table = Table(
        box=None, header_style="bold", title="Adhesion and pad friction against the truth", title_justify="left"
    )
    heads = ("scenario", "filter", "α rmse", "α outside events", "longest > 0.02", "kept", "μ rmse", "μ bias", "μ NEES")
    for column in heads:
        table.add_column(column)
    for row in rows:
        table.add_row(
            row.scenario,
            row.filter,
            f"{row.alpha_rmse:.4f}",
            f"{row.alpha_outside:.4f}",
            f"{1e3 * row.longest:.0f} ms",
            "yes" if row.kept else "no",
            f"{row.mu_b_rmse:.4f}",
            f"{row.mu_b_bias:+.4f}",
            f"{row.mu_b_nees:.2g}",
        )
    _out.print(table)
    _out.print(f"{out}/rig.md", highlight=False, soft_wrap=True)


def add_to(app: typer.Typer) -> None:
    """Put the commands of this room on a command line."""
    app.command()(observability)
    app.command()(estimate)
    app.command()(rig)


def _say_flags(recording: "xarray.Dataset") -> None:
    """Print what was mended in a user's file."""
    for sentence in recording.attrs.get("flags", ()):
        _out.print(f"{recording.attrs['name']}: {sentence}", highlight=False, markup=False, soft_wrap=True)


def _print_errors(recording: "xarray.Dataset", told: "xarray.Dataset") -> None:
    """Print how far off each state was whose truth is known."""
    from harness.estimate.judge import judge
    from harness.estimate.recording import TRUTH

    _out.print(
        f"{recording.attrs['name']}: median NIS is {told.attrs['nis_ratio']:.3g} of the expected one; above 1 the "
        "filter is surer than its readings allow.",
        highlight=False, markup=False, soft_wrap=True,
    )  # fmt: skip
    known = [str(state) for state in told["state"].values if TRUTH + str(state) in recording]
    if not known:
        return
    table = Table(box=None, header_style="bold", title=f"{recording.attrs['name']}: estimate minus truth")
    for column in ("state", "rmse", "of the best constant", "bias", "largest", "NEES", "within 2 sd"):
        table.add_column(column, justify="left" if column == "state" else "right")
    for state in known:
        found = judge(recording, told, state)
        table.add_row(
            state,
            f"{found.rmse:.4g}",
            f"{found.constant:.4g}",
            f"{found.bias:+.4g}",
            f"{found.largest:.4g}",
            f"{found.nees:.3g}",
            f"{100 * found.covered:.1f} %",
        )
    _out.print(table)


def _write_windows(windows: object, path: Path) -> None:
    """Write smallest singular values and deviations as CSV, a row a window."""
    import xarray

    from harness.record.atomic import replacing

    assert isinstance(windows, xarray.Dataset)
    states = [str(state) for state in windows["state"].values]
    head = ["time_s", "smallest", *(f"singular_{s}" for s in states), *(f"deviation_{s}" for s in states)]
    with replacing(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(head)
        for k, time in enumerate(windows["time"].values):
            row = windows.isel(time=k)
            values = [row["smallest"].item(), *row["singular"].values, *row["deviation"].values]
            writer.writerow([f"{time:.6g}", *(f"{value:.6g}" for value in values)])
