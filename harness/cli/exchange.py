"""FMUs for other tools and of other tools: export a controller, map a plant."""

from pathlib import Path
from typing import Annotated

import typer

from railgrip.base.errors import PlantFailed
from railgrip.campaign.one_stop import make_folder
from railgrip.cli.app import RUN_FAILED, File, Overrides, With
from railgrip.fmi import Signal, bind, describe, open_plant
from railgrip.fmi.description import Causality
from railgrip.fmi.draft import drafted
from railgrip.fmus.native.package import pack
from railgrip.report.console import say
from railgrip.scenario.load import load
from railgrip.simulate.export import controller_fmu
from railgrip.simulate.files import parameters_of
from railgrip.simulate.loop.plausible import slowing_of
from railgrip.simulate.plant import plant_signals
from railgrip.simulate.trial import GOOD_RAIL, POOR_RAIL, Trial, findings, tried
from railgrip.simulate.vehicle import catalogue_brakes, catalogue_counts
from railgrip.vehicle.formation import Formation, carried_mass
from railgrip.vehicle.parameters import counts_of
from railgrip.vehicle.signals import layout_of


def export(
    file: File,
    equipment: With = None,
    overrides: Overrides = None,
    out: Annotated[Path | None, typer.Option(help="The FMU; build/NAME-CONTROLLER.fmu unless given.")] = None,
) -> None:
    """Make an FMU of a scenario's controller for another tool."""
    scenario = load(file, overrides or [], equipment or [])
    place = out or Path("build") / f"{scenario.name}-{scenario.controller.kind}.fmu"
    make_folder(place.parent, place.name)
    fmu = pack(controller_fmu(scenario), place)
    say(str(fmu))


def map_(
    file: Annotated[Path, typer.Argument(metavar="TRAIN.fmu", help="A co-simulation FMU.")],
    speed: Annotated[float, typer.Option(min=1, max=150, help="Of the short run at its start [m/s].")] = 20.0,
    per_group: Annotated[
        list[int] | None,
        typer.Option("--wheelsets-of-group", min=1, help="Of each group, leading first; as the FMU says."),
    ] = None,
    period: Annotated[float, typer.Option(min=1e-5, max=0.1, help="Communication period of it [s].")] = 1e-3,
) -> None:
    """Print a draft of [vehicle.map] for the FMU of another tool."""
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
