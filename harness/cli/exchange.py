"""Commands for FMUs: export the parts of a scenario for other tools, and map foreign plants."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

import typer

from railgrip.base.errors import InputError, PlantFailed
from railgrip.base.names import did_you_mean
from railgrip.base.records import make_folder, require_own
from railgrip.cli.app import RUN_FAILED, File, Overrides, With
from railgrip.fmi import describe
from railgrip.fmus.native.package import as_fmi_3, pack
from railgrip.fmus.native.toolchain import TARGETS
from railgrip.report.console import remark, say
from railgrip.scenario.load import load
from railgrip.simulate.export.c_parts import part_fmu, write_library
from railgrip.simulate.export.controller_and_plant import controller_fmu, plant_fmu
from railgrip.simulate.export.ssp import write_ssp
from railgrip.simulate.map_draft import controller_lines, find_mapping
from railgrip.simulate.named_models import require_role, role_of

Part = Literal["onboard", "controller", "plant", "track", "sensors", "estimator"]
"""Part of a scenario to export as an FMU."""


def _fmi(version: int) -> int:
    if version not in (2, 3):
        raise typer.BadParameter(f"FMI {version} is not supported; choose 2 or 3")
    return version


def export(
    file: File,
    equipment: With = None,
    overrides: Overrides = None,
    out: Annotated[Path | None, typer.Option(help="File for the FMU; build/NAME-PART.fmu unless given.")] = None,
    part: Annotated[
        Part,
        typer.Option(
            help="onboard: estimator, law and valves from readings to commands; controller: law and valves alone; "
            "track: rail and driver."
        ),
    ] = "onboard",
    fmi: Annotated[int, typer.Option(metavar="2|3", callback=_fmi, help="Version of FMI.")] = 2,
    platforms: Annotated[
        list[str] | None,
        typer.Option(
            "--platforms", metavar="NAME", help=f"{', '.join(TARGETS)}, or all; repeatable. This one unless given."
        ),
    ] = None,
    library: Annotated[
        bool,
        typer.Option(
            "--library", help="Instead of an FMU, write a folder with static library, header and C of the onboard part."
        ),
    ] = False,
    ssp: Annotated[
        Path | None, typer.Option(help="Instead of one FMU, write the whole loop as a system of FMUs, SSP 1.0.")
    ] = None,
) -> None:
    """Make FMUs of a scenario for another tool: a part or the whole loop."""
    scenario, targets = load(file, overrides or [], equipment or []), _targets(platforms or [])
    if ssp is not None:
        if out is not None or fmi == 3 or part != "onboard" or library:
            raise InputError(
                "--ssp writes all parts by FMI 2 into one file; leave out --out, --part, --fmi and --library."
            )
        make_folder(ssp.parent, ssp.name)
        say(str(write_ssp(scenario, ssp, targets)))
        return
    if library:
        if fmi == 3 or targets or part != "onboard":
            raise InputError(
                "--library compiles the onboard part for this machine; leave out --part, --fmi and --platforms."
            )
        folder = out or Path("build") / f"{scenario.name}-library"
        require_own(folder)
        make_folder(folder, "library")
        for file in write_library(scenario, folder):
            say(str(file))
        return
    place = out or Path("build") / f"{scenario.name}-{part}.fmu"
    make_folder(place.parent, place.name)
    match part:
        case "controller":
            source = controller_fmu(scenario)
        case "plant":
            source = plant_fmu(scenario)
        case _:
            source = part_fmu(scenario, part)
    say(str(pack(as_fmi_3(source) if fmi == 3 else source, place, platforms=targets)))


def _targets(names: Sequence[str]) -> tuple[str, ...]:
    wanted = [each for name in names for each in name.split(",")]
    unknown = [name for name in wanted if name not in (*TARGETS, "all")]
    if unknown:
        raise InputError(
            f"--platforms: there is no platform {', '.join(unknown)}; there is {', '.join(TARGETS)}, and all"
            + did_you_mean(unknown[0], [*TARGETS, "all"], before="; ")
        )
    return tuple(name for name in TARGETS if name in wanted or "all" in wanted)


def map_(
    file: Annotated[Path, typer.Argument(metavar="FILE.fmu", help="FMU of a plant or a controller, FMI 2.0 or 3.0.")],
    speed: Annotated[float, typer.Option(min=1, max=150, help="Speed at the start of the short run [m/s].")] = 20.0,
    per_group: Annotated[
        list[int] | None,
        typer.Option(
            "--wheelsets-of-group",
            min=1,
            help="Number of wheelsets of each group, leading first; as declared by the FMU unless given.",
        ),
    ] = None,
    period: Annotated[
        float | None,
        typer.Option(min=1e-5, max=0.1, help="Communication period of the short run [s]; 1 ms, or the FMU's own step."),
    ] = None,
) -> None:
    """Print the tables of a scenario for the FMU of another tool.

    The FMU is a plant or a controller.
    """
    description = describe(file)
    if role_of(description) == "controller":
        for line in controller_lines(description):
            say(line)
        return
    require_role(description, "plant", "railgrip map")
    own_step = None if description.co_simulation is None else description.co_simulation.only_step
    try:
        draft = find_mapping(
            description,
            wheelsets_per_group=tuple(per_group or ()),
            speed=speed,
            period=period or own_step or 1e-3,
            notify=remark,
        )
    except PlantFailed as failed:
        say(f"# the short run failed: {failed}")
        raise typer.Exit(RUN_FAILED) from failed
    for line in draft.lines():
        say(line)
