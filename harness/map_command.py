"""`railgrip map`: prints a draft of [vehicle.map] and what a short run with it shows."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    # Loaded when the command runs: `--help` must not wait for the FMU loader.
    from railgrip.fmu import Signal
    from railgrip.fmu.description import Causality


def add_to(app: typer.Typer) -> None:
    """Add the command."""

    @app.command(name="map")
    def map_(  # pyright: ignore[reportUnusedFunction]
        file: Annotated[Path, typer.Argument(metavar="TRAIN.fmu", help="A co-simulation FMU.")],
        speed: Annotated[float, typer.Option(min=1, max=150, help="Of the short run at its start [m/s].")] = 20.0,
        per_group: Annotated[
            list[int] | None,
            typer.Option("--wheelsets-of-group", min=1, help="Of each group, leading first; as the FMU says."),
        ] = None,
        period: Annotated[float, typer.Option(min=1e-5, max=0.1, help="Communication period of it [s].")] = 1e-3,
    ) -> None:
        """Print a draft of [vehicle.map] for a train of one's own, and what a short run with it shows."""
        from railgrip.assemble import catalogue_brakes, catalogue_counts, counts_of, parameters_of, plant_signals
        from railgrip.draft import drafted
        from railgrip.errors import PlantFailed
        from railgrip.fmu import bind, describe, open_plant
        from railgrip.formation import Formation
        from railgrip.signals import layout_of
        from railgrip.trial import findings, tried

        description = describe(file)
        formation = Formation(tuple(per_group or counts_of(parameters_of(description)) or catalogue_counts()))
        inputs, outputs, start = plant_signals(layout_of(formation), pneumatic=False, track_force=False)
        wanted: dict[str, tuple[Signal, Causality]] = {s.name: (s, "input") for s in inputs}
        wanted |= {s.name: (s, "output") for s in outputs}
        wanted[start.name] = (start, "parameter")
        table = drafted(description, wanted)
        typer.echo("[vehicle.map]")
        for name, (signal, _) in wanted.items():
            if name in table:
                typer.echo(f'{name} = "{table[name]}"')
            elif signal.needed:
                typer.echo(f"# {name} = ?  # needed, in {signal.unit}: nothing like it was found")
        typer.echo("")
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
        plant = open_plant(
            description, binding, period=period, parameters=binding.translated({"speed_start": speed}), trusted=False,
            tell=lambda sentence: None,
        )  # fmt: skip
        try:
            with plant as opened:
                trial = tried(layout_of(formation), opened, period=period, release=(0.0,) * len(groups), brake=pressure)
        except PlantFailed as failed:
            typer.echo(f"# the short run failed: {failed}")
            raise typer.Exit(3) from failed
        for finding in findings(trial, speed=speed, radius=radius, pressure=pressure):
            typer.echo(f"# {'fits' if finding.good else 'WRONG'}: {finding.signal} {finding.sentence}")
