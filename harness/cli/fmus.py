"""Commands for the FMUs of built-in or user-defined Modelica classes: build, list and check."""

import shutil
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, cast

import typer

from railgrip.base.errors import InputError
from railgrip.cli.app import fail
from railgrip.fmi.survey import SurveyResult, survey, validation_problems
from railgrip.fmus.build import OUTPUT, Compiler, build, build_class, translate
from railgrip.fmus.recipe import LOCK, Entry, differences, read_lock, read_recipes, write_lock
from railgrip.report.console import progress, say, show_table
from railgrip.report.marked import write_tables
from railgrip.report.table import ReportTable


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
        with progress("building"):
            for artifact in build(names or (), choice):
                say(f"{artifact.path}  {artifact.action} ({artifact.compiler})")


def _build_class(name: str, library: list[Path], compiler: Compiler, out: Path | None) -> None:
    artifact = build_class(name, library, compiler=compiler)
    file = Path(f"{artifact.name}.fmu") if out is None else out
    file.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(artifact.path, file)
    say(f"{file}  {artifact.action} ({artifact.compiler})")


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


PAGE = Path("docs/foreign_fmus.md")


def survey_command(
    folder: Annotated[Path, typer.Argument(exists=True, file_okay=False, help="Folder of FMUs, searched recursively.")],
    out: Annotated[Path, typer.Option(help="File for one line per FMU.")] = Path("build/fmus.csv"),
    write: Annotated[bool, typer.Option("--write", help=f"Write the table into {PAGE}.")] = False,
) -> None:
    """Open and step the FMUs of a folder; write a table.

    Each FMU runs in a separate process. The file gives the reason for each that does not step.
    """
    with progress("stepping"):
        rows = [*survey(folder)]
    if not rows:
        raise InputError(f"{folder}: contains no file *.fmu, not even in subfolders.")
    out.parent.mkdir(parents=True, exist_ok=True)
    lines = ("file", "tool", "FMI", "reason", "sentence")
    ReportTable.of(lines, [(str(r.file), r.tool, r.interface, r.reason, r.sentence) for r in rows], left=5).write_csv(
        out
    )
    table = _survey_table(rows)
    show_table(table)
    if write:
        write_tables(PAGE, {"fmus": table})


def _survey_table(rows: Sequence[SurveyResult]) -> ReportTable:
    kinds = dict.fromkeys(sorted((row.tool.lower(), row.tool, row.interface) for row in rows))
    lines: list[tuple[str, str, int, int, str]] = []
    for _, tool, interface in kinds:
        group = [row for row in rows if (row.tool, row.interface) == (tool, interface)]
        reasons = Counter(row.reason for row in group if row.reason)
        why = "; ".join(f"{count} {reason}" for reason, count in reasons.most_common())
        lines.append((tool, interface, len(group), len(group) - reasons.total(), why))
    stepping = {row.file for row in rows if not row.reason}
    lines.append(("all, each counted once", "", len({row.file for row in rows}), len(stepping), ""))
    return replace(
        ReportTable.of(("tool", "FMI", "FMUs", "step", "refused or failed, why"), lines, left=2),
        left=("tool", "FMI", "refused or failed, why"),
    )


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
