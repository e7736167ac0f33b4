"""Commands for monitoring.

They run an instrumented car with a trained estimator, and follow the condition of pads over several stops.
"""

from pathlib import Path
from typing import Annotated

import typer

from railgrip.base.errors import EstimationError
from railgrip.base.files import write_bytes
from railgrip.base.records import adopt, claim, require_free
from railgrip.estimation.spec import load_specification
from railgrip.report.console import progress, remark, say, show_table
from railgrip.report.style import save
from railgrip.studies.axle_box.ride import read_ride, ride_figure, ride_with_estimator
from railgrip.studies.pad_monitor.watch import MonitorDesign, draw, health_table, stops_in, summary_of, watch

RIDE_FILES = ("ride.nc", "ride.png")
"""Files that `railgrip ride` writes."""


def ride(
    file: Annotated[Path, typer.Argument(metavar="FILE.toml", help="A ride: car, run, and estimator.")],
    out: Annotated[
        Path | None, typer.Option(help="Folder for trace and figure; build/rides/NAME unless given.")
    ] = None,
) -> None:
    """Run the instrumented car with a trained friction estimator."""
    specification = read_ride(file)
    folder = out or Path("build/rides") / specification.name
    if out is None:
        adopt(folder, *RIDE_FILES)
    require_free(folder, *RIDE_FILES)
    with progress(specification.name, 1.0) as bar:
        trace, apart = ride_with_estimator(specification, file.parent, lambda share: bar.update(amount=share), remark)
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
    with progress("reading") as bar:
        evidence, sentences = stops_in(
            folder,
            None if column_map is None else load_specification(column_map),
            lambda number, of: bar.update(doing=f"stop {number} of {of}"),
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
