"""One scenario or one plant: run, export and map."""

from collections.abc import Sequence
from functools import partial
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from railgrip.cli.app import RUN_FAILED, File, ImportFrom, Overrides, app, fail
from railgrip.console import progress, remark, say
from railgrip.errors import InputError

if TYPE_CHECKING:
    from railgrip.campaign.one_stop import Runner
    from railgrip.fmu import Signal
    from railgrip.fmu.description import Causality


@app.command()
def run(
    file: File,
    overrides: Overrides = None,
    out: Annotated[Path | None, typer.Option(help="Folder for the result; build/runs/NAME unless given.")] = None,
    engine: Annotated[str | None, typer.Option(hidden=True)] = None,
    import_from: ImportFrom = None,
) -> None:
    """Run one scenario and print its figures."""
    from railgrip.campaign.one_stop import run as run_scenario
    from railgrip.scenario.load import load

    if engine is not None:
        raise InputError("--engine: there is one loop for all stops now; leave it out")
    scenario = load(file, overrides or [])
    directory = out or Path("build/runs") / scenario.name
    with progress(scenario.name, scenario.start.speed or None) as bar:
        stop = run_scenario(
            scenario,
            directory,
            runner(import_from or ()),
            lambda speed: bar.update(amount=scenario.start.speed - speed),
            remark,
        )
    metrics = stop.metrics
    # A plant from outside may not show its adhesion; then there is no share of it to tell.
    share = (
        f", {100 * metrics.utilisation:.1f} % of the possible adhesion used" if isfinite(metrics.utilisation) else ""
    )
    if metrics.utilisation > 1.001:  # physics allows it: the possible also ends at what the operator allows
        share += (
            f" ([limits] alpha_max {scenario.limits.alpha_max:g} exceeded for {max(metrics.time_over_alpha_max):.2f} s)"
        )
    travelled = f"{metrics.distance_travelled:.2f} m in {metrics.duration:.2f} s"
    say(f"{scenario.name}: {stop.outcome.value}, {travelled}{share}")
    for sentence in metrics.doubts():
        say(f"{scenario.name}: {sentence}")
    if stop.limited_demands:
        say(f"{scenario.name}: {stop.reason}")
    say(f"{directory}/stop.json")
    if stop.outcome.value != "standstill":
        fail(f"{scenario.name}: no braking distance, the stop ended with {stop.outcome.value}: {stop.reason}")


@app.command()
def export(
    file: File,
    overrides: Overrides = None,
    out: Annotated[Path | None, typer.Option(help="The FMU; build/NAME-CONTROLLER.fmu unless given.")] = None,
) -> None:
    """Make an FMU of a scenario's controller, valve logic included, for another tool on this platform."""
    from railgrip.campaign.one_stop import make_folder
    from railgrip.scenario.load import load

    scenario = load(file, overrides or [])
    place = out or Path("build") / f"{scenario.name}-{scenario.controller.kind}.fmu"
    make_folder(place.parent, place.name)
    # CasADi and the compiler come after the questions that need neither.
    from railgrip.assemble.export import controller_fmu
    from railgrip.fmus.native.package import pack

    fmu = pack(controller_fmu(scenario), place)
    say(str(fmu))


@app.command(name="map")
def map_(
    file: Annotated[Path, typer.Argument(metavar="TRAIN.fmu", help="A co-simulation FMU.")],
    speed: Annotated[float, typer.Option(min=1, max=150, help="Of the short run at its start [m/s].")] = 20.0,
    per_group: Annotated[
        list[int] | None,
        typer.Option("--wheelsets-of-group", min=1, help="Of each group, leading first; as the FMU says."),
    ] = None,
    period: Annotated[float, typer.Option(min=1e-5, max=0.1, help="Communication period of it [s].")] = 1e-3,
) -> None:
    """Print a draft of [vehicle.map] for a train of one's own, and what a short run with it shows."""
    from railgrip.assemble.files import parameters_of
    from railgrip.assemble.plant import plant_signals
    from railgrip.assemble.trial import GOOD_RAIL, POOR_RAIL, Trial, findings, tried
    from railgrip.assemble.vehicle import catalogue_brakes, catalogue_counts
    from railgrip.errors import PlantFailed
    from railgrip.fmu import bind, describe, open_plant
    from railgrip.fmu.draft import drafted
    from railgrip.loop.plausible import slowing_of
    from railgrip.signals import layout_of
    from railgrip.vehicle.formation import Formation, carried_mass
    from railgrip.vehicle.parameters import counts_of

    description = describe(file)
    formation = Formation(tuple(per_group or counts_of(parameters_of(description)) or catalogue_counts()))
    inputs, outputs, start = plant_signals(layout_of(formation), pneumatic=False, track_force=False)
    signals: dict[str, tuple[Signal, Causality]] = {s.name: (s, "input") for s in inputs}
    signals |= {s.name: (s, "output") for s in outputs}
    signals[start.name] = (start, "parameter")
    table = drafted(description, signals)
    say("[vehicle.map]")
    for name, (signal, _) in signals.items():
        if name in table:
            say(f'{name} = "{table[name]}"')
        elif signal.needed:
            say(f"# {name} = ?  # needed, in {signal.unit}: nothing like it was found")
    say("")
    binding = bind(
        description,
        inputs=inputs,
        outputs=outputs,
        parameters=(start,),
        table=table,
        where="the draft of [vehicle.map]",
    )
    groups = catalogue_brakes(formation.groups)
    pressure, radius = tuple(g.pressure_max for g in groups), tuple(g.wheel_radius for g in groups)
    slowing = slowing_of(carried_mass(sum(group.load for group in groups)), is_known=False)
    trials: list[Trial] = []
    try:
        for friction in (GOOD_RAIL, POOR_RAIL):
            with open_plant(
                description, binding, period=period, parameters=binding.translate({"start_speed": speed}),
                trusted=False, notify=lambda sentence: None,
            ) as fmu:  # fmt: skip
                trials.append(
                    tried(
                        layout_of(formation), fmu, period=period, release=(0.0,) * len(groups), brake=pressure,
                        friction=friction,
                    )
                )  # fmt: skip
    except PlantFailed as failed:
        say(f"# the short run failed: {failed}")
        raise typer.Exit(RUN_FAILED) from failed
    for finding in findings(*trials, speed=speed, radius=radius, pressure=pressure, slowing=slowing):
        say(f"# {'fits' if finding.good else 'WRONG'}: {finding.signal} {finding.sentence}")


def runner(import_from: Sequence[Path] = ()) -> "Runner":
    """Return what runs a scenario; picklable."""
    # Loaded only when something runs: it brings CasADi and the FMU loader, and `report` needs neither.
    from railgrip.assemble import run_stop

    if not import_from:
        return run_stop
    from railgrip.assemble import OwnParts

    return partial(run_stop, own=OwnParts(folders=tuple(import_from)))
