"""Commands of this room: observability, estimate and rig; `add_to` puts them on the command line."""

import csv
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

_out = Console()
_err = Console(stderr=True)

OUT = Path("build/estimate")

File = Annotated[
    Path, typer.Argument(metavar="FILE.toml", help="An estimation; examples are in harness/estimate/library.")
]
Out = Annotated[Path | None, typer.Option(help="Folder for the results; build/estimate/NAME unless given.")]


def observability(file: File, out: Out = None) -> None:
    """Ask what the recording of an estimation can tell about each state, and plot it along the way."""
    from harness.estimate.observable import observe
    from harness.estimate.sources import recording_for
    from harness.estimate.spec import load_specification, prediction_for
    from harness.verdict.observability import information

    specification = load_specification(file)
    folder = out or OUT / specification.name
    with _err.status(f"{specification.name}: recording"):
        recording = recording_for(specification.twin())
    with _err.status(f"{specification.name}: windows"):
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
    out: Out = None,
    scenario: Annotated[str | None, typer.Option(help="Another scenario of the same source.")] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Of the source; the scenario's own unless given.")] = None,
    data: Annotated[
        Path | None, typer.Option(metavar="RUN", help="Recorded csv, parquet, mat or mf4 file, read by [data].")
    ] = None,
) -> None:
    """Run the filter of an estimation over its recording; write what it believes and how far off it was."""
    from harness.estimate.judge import judge
    from harness.estimate.recorded.specified import taken_for
    from harness.estimate.recording import TRUTH
    from harness.estimate.run import estimate as run_filter
    from harness.estimate.run import units_of
    from harness.estimate.sources import recording_for
    from harness.estimate.spec import load_specification, prediction_for, settings_for
    from harness.record.atomic import replacing

    specification = load_specification(file)
    folder = out or OUT / specification.name
    if data is not None:
        recording = taken_for(specification, data).recording
        for sentence in recording.attrs["flags"]:
            _out.print(f"{data.name}: {sentence}", highlight=False, markup=False, soft_wrap=True)
    else:
        twin = specification.twin()
        changed = {"scenario": scenario or twin.scenario, "seed": seed}
        source = twin.model_copy(update={k: v for k, v in changed.items() if v is not None})
        with _err.status(f"{specification.name}: recording"):
            recording = recording_for(source)
    with _err.status(f"{specification.name}: filter"):
        told = run_filter(
            recording,
            prediction_for(specification),
            settings_for(specification, float(recording.attrs["period"])),
            units=units_of(specification.model.class_),
        )
    with replacing(folder / "estimates.nc") as partial:
        told.to_netcdf(partial, engine="h5netcdf")
    known = [str(state) for state in told["state"].values if TRUTH + str(state) in recording]
    table = Table(box=None, header_style="bold", title=f"{recording.attrs['name']}: estimate minus truth")
    for column in ("state", "rmse", "bias", "largest", "NEES", "within 2 sd"):
        table.add_column(column, justify="left" if column == "state" else "right")
    for state in known:
        found = judge(recording, told, state)
        table.add_row(
            state,
            f"{found.rmse:.4g}",
            f"{found.bias:+.4g}",
            f"{found.largest:.4g}",
            f"{found.nees:.3g}",
            f"{100 * found.covered:.1f} %",
        )
    if known:
        _out.print(table)
    _out.print(f"{folder}/estimates.nc", highlight=False, soft_wrap=True)
    if told.attrs["ended"]:
        _err.print(f"{specification.name}: {told.attrs['ended']}", style="red", highlight=False, markup=False)
        raise typer.Exit(3)


def rig(out: Annotated[Path, typer.Option(help="Folder for figures and tables.")] = OUT / "rig") -> None:
    """Run the roller-rig tests of Schwarz and Keck (2020) with their filter and ours; write figures and tables."""
    from harness.estimate.rig import study

    with _err.status("rig") as status:
        rows = study(out, status.update)
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
