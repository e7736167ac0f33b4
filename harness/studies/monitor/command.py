"""`railgrip monitor`: health of brakes from a folder of stops; `railgrip monitor-study`: how good the monitor is."""

from pathlib import Path
from typing import Annotated

import typer

from railgrip.console import progress, say, show_table
from railgrip.studies.monitor.transducers import PRESSURE_OFFSET


def add_to(app: typer.Typer) -> None:
    """Register the commands."""
    app.command(name="monitor")(monitor)
    app.command(name="monitor-study")(monitor_study)


def monitor(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of stops, in the order of their names.")],
    column_map: Annotated[
        Path | None, typer.Option("--map", metavar="FILE.toml", help="Estimation whose [data] maps recorded files.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Figure; DIR/monitor.png unless given.")] = None,
) -> None:
    """Follow the friction of each brake group from stop to stop, print and plot its health, trend and alarms."""
    from railgrip.estimation.spec import load_specification
    from railgrip.studies.monitor.folder import stops_in
    from railgrip.studies.monitor.page import draw, health_table, verdict_on
    from railgrip.studies.monitor.watch import Design, watch

    with progress("reading") as shown:
        found = stops_in(
            folder,
            None if column_map is None else load_specification(column_map),
            lambda done, of: shown.update(doing=f"stop {done} of {of}"),
        )
    for sentence in found.sentences:
        say(sentence)
    if not found.evidence:
        from railgrip.errors import EstimationError

        raise EstimationError(f"{folder}: none of its stops can be used.")
    design = Design()
    history = watch(found.evidence, design)
    show_table(health_table(history, found.names))
    say(verdict_on(history, design))
    say(str(draw(history, design, out or folder / "monitor.png")))


def monitor_study(
    out: Annotated[Path, typer.Option(help="Folder for figure and figures.")] = Path("build/monitor"),
    seeds: Annotated[int, typer.Option(min=1, help="Lives.")] = 20,
    stops: Annotated[int, typer.Option(min=40, help="Stops of each.")] = 200,
    workers: Annotated[int, typer.Option(min=1, max=64, help="Processes.")] = 2,
    pressure_offset: Annotated[
        float, typer.Option(min=0.0, help="1σ of what pressure transducers are off for a whole life [Pa].")
    ] = PRESSURE_OFFSET,
) -> None:
    """Simulate lives with a worn and a sticking brake; print delays of alarms and the rate of false ones."""
    from railgrip.studies.monitor.page import draw
    from railgrip.studies.monitor.study import evidence_of_life, lives, study
    from railgrip.studies.monitor.watch import Design, watch

    design, asked = Design(), lives(seeds, stops, pressure_offset)
    with progress("lives", seeds, counted=True) as shown:
        verdict = study(asked, design, workers=workers, tell=lambda done: shown.update(done=done))
    show_table(verdict.table())
    first = watch(evidence_of_life(asked[0]), design)
    say(str(draw(first, design, out / "life.png")))
