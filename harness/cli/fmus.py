"""Commands for FMUs: build, list and check those of Modelica classes, export parts of a scenario, map foreign ones."""

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal, cast

import typer

from railgrip.base.errors import InputError, PlantFailed
from railgrip.base.names import did_you_mean
from railgrip.base.records import make_folder, require_own
from railgrip.cli.app import RUN_FAILED, File, ImportFrom, Overrides, With, fail
from railgrip.fmi import describe
from railgrip.fmi.trials import validation_problems
from railgrip.fmus.build import OUTPUT, Compiler, build, build_class, translate
from railgrip.fmus.native.package import as_fmi_3, pack
from railgrip.fmus.native.toolchain import TARGETS
from railgrip.fmus.recipe import LOCK, Entry, differences, read_lock, read_recipes, write_lock
from railgrip.report.console import progress, remark, say, show_table
from railgrip.report.table import ReportTable
from railgrip.scenario.load import load
from railgrip.simulate.export.browser import write_page
from railgrip.simulate.export.c_parts import part_fmu, write_library
from railgrip.simulate.export.controller_and_plant import controller_fmu, plant_fmu
from railgrip.simulate.export.ssp import write_ssp
from railgrip.simulate.map_draft import controller_lines, find_mapping
from railgrip.simulate.named_models import require_role, role_of
from railgrip.simulate.user_parts import CustomParts


def build_command(
    names: Annotated[list[str] | None, typer.Argument(help="Names of FMUs, see --list; all unless given.")] = None,
    compiler: Annotated[str, typer.Option(help="auto, openmodelica or native.")] = "auto",
    library: Annotated[
        list[Path] | None,
        typer.Option(
            help="Folder, package.mo or .mo file of a user-defined class, whose name replaces the names of FMUs; "
            "again for each further library that it uses and that is not in MODELICAPATH."
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="File for its FMU; CLASS.fmu unless given.")] = None,
    listing: Annotated[bool, typer.Option("--list", help="List the recipes and the existing FMUs.")] = False,
    check: Annotated[
        bool, typer.Option("--check", help="Validate FMUs against the FMI standard and compare them with lock.toml.")
    ] = False,
    update: Annotated[bool, typer.Option("--update", help="With --check: write lock.toml.")] = False,
) -> None:
    """Update FMUs, or build a plant from your own class.

    Copies are left in build/fmus of the current folder.
    """
    if update and not check:
        raise InputError("--update needs --check: both together write lock.toml instead of comparing with it.")
    choice = cast("Compiler", compiler)
    if listing:
        _list()
    elif check:
        _check(names or [], choice, update=update)
    elif library:
        if names is None or len(names) != 1:
            raise InputError("--library is for one class; name it, as in `build --library MyLib MyLib.MyTrain`.")
        _build_class(names[0], library, choice, out)
    elif out is not None:
        raise InputError("--out is for a class of your --library; recipes are copied to build/fmus.")
    else:
        with progress("build", "reading recipes"):
            for artifact in build(names or (), choice):
                say(f"{artifact.path}  {artifact.action} ({artifact.compiler})")


def _build_class(name: str, library: list[Path], compiler: Compiler, out: Path | None) -> None:
    artifact = build_class(name, library, compiler=compiler)
    file = Path(f"{artifact.name}.fmu") if out is None else out
    file.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(artifact.path, file)
    say(f"{file}  {artifact.action} ({artifact.compiler})")
    fixed = [f"{key} = {str(value).lower()}" for key, value in artifact.interface.get("compiled_in", {}).items()]
    if fixed:
        remark(
            f"{file}: {', '.join(fixed)} cannot be set in the FMU, because sizes and equations may depend on what is "
            f"not Real. For other values build a class that extends {name}, as in "
            f"model Other extends {name}({fixed[0].partition(' ')[0]} = ...); end Other;"
        )


def _list() -> None:
    rows = [
        {
            "FMU": name,
            "class": recipe.class_name,
            "interfaces": " ".join(recipe.interfaces),
            "solver": recipe.solver,
            "tolerance": f"{recipe.tolerance:g}",
            "on disk": "yes" if (OUTPUT / f"{name}.fmu").exists() else "no",
        }
        for name, recipe in read_recipes().recipes.items()
    ]
    show_table(ReportTable(rows, left=list(rows[0])))


def _check(names: list[str], compiler: Compiler, *, update: bool) -> None:
    book = read_recipes()
    complaints: list[str] = []
    interfaces: dict[str, Entry] = {}
    for artifact in build(() if update else names, compiler):
        complaints += [f"{artifact.name}.fmu: {problem}" for problem in validation_problems(artifact.path)]
        # The lock file records the results of the built-in compiler, also where another one made the FMU.
        interfaces[artifact.name] = artifact.interface or translate(book[artifact.name])[1]
    if update:
        write_lock(book, interfaces)
        say(f"{LOCK} written")
    else:
        lock = read_lock()
        complaints += [
            f"{name}: {what}" for name, interface in interfaces.items() for what in differences(name, lock, interface)
        ]
    if complaints:
        fail(*complaints)
    say(f"{len(interfaces)} FMUs are valid" + ("" if update else " and match lock.toml"))


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
    page: Annotated[
        Path | None,
        typer.Option(metavar="FILE.html", help="Instead of an FMU, write a page that runs the stop in a browser."),
    ] = None,
    import_from: ImportFrom = None,
) -> None:
    """Make FMUs of a scenario for another tool, or a page that runs its stop."""
    scenario, targets = load(file, overrides or [], equipment or []), _targets(platforms or [])
    objects = CustomParts(folders=tuple(import_from or ()))
    others = out is not None or fmi == 3 or part != "onboard" or library
    if page is not None and (others or targets or ssp is not None):
        raise InputError("--page writes the whole stop for all platforms into one file; leave out the other options.")
    if ssp is not None and others:
        raise InputError("--ssp writes all parts by FMI 2 into one file; leave out --out, --part, --fmi and --library.")
    if page is not None:
        make_folder(page.parent, page.name)
        for sentence in write_page(
            lambda more: load(file, [*(overrides or []), *more], equipment or []), page, objects
        ):
            remark(sentence)
        say(str(page))
        return
    if ssp is not None:
        make_folder(ssp.parent, ssp.name)
        say(str(write_ssp(scenario, ssp, targets, objects)))
        return
    if library:
        if fmi == 3 or targets or part != "onboard":
            raise InputError(
                "--library compiles the onboard part for this machine; leave out --part, --fmi and --platforms."
            )
        folder = out or Path("build") / f"{scenario.name}-library"
        require_own(folder)
        make_folder(folder, "library")
        for file in write_library(scenario, folder, objects):
            say(str(file))
        return
    place = out or Path("build") / f"{scenario.name}-{part}.fmu"
    make_folder(place.parent, place.name)
    match part:
        case "controller":
            source = controller_fmu(scenario, objects=objects)
        case "plant":
            source = plant_fmu(scenario)
        case _:
            source = part_fmu(scenario, part, objects=objects)
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
