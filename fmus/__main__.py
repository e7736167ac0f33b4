"""Command line: python -m railgrip.fmus build | list | check."""

import shutil
import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from railgrip.errors import InputError, RailgripError
from railgrip.fmus.build import OUTPUT, Compiler, build, build_class, choose, translate
from railgrip.fmus.recipe import read_recipes

app = typer.Typer(no_args_is_help=True, add_completion=False, help="Modelica classes to FMI 2.0 FMUs.")
# Where nobody watches, a table is not cut to a screen that is not there.
out = Console(width=None if sys.stdout.isatty() else 140)
err = Console(stderr=True)

Names = Annotated[list[str] | None, typer.Argument(help="FMUs of recipes.toml; all when none is named")]
Choice = Annotated[str, typer.Option(help="auto, openmodelica or native")]


def _compiler(text: str) -> Compiler:
    choose(text)  # pyright: ignore[reportArgumentType] - which is what checks it
    return text  # pyright: ignore[reportReturnType]


@app.command("build")
def build_command(
    names: Names = None,
    compiler: Choice = "auto",
    library: Annotated[
        Path | None,
        typer.Option(help="folder, package.mo or .mo file of a class of your own, named in place of FMUs"),
    ] = None,
    output: Annotated[Path | None, typer.Option("--out", help="file for its FMU; CLASS.fmu when absent")] = None,
) -> None:
    """Bring FMUs up to date and leave copies in build/fmus, or build the plant of a class of your own."""
    if library is not None:
        if names is None or len(names) != 1:
            raise InputError("--library is for one class; name it, as in `build --library MyLib MyLib.MyTrain`.")
        artifact = build_class(names[0], library, compiler=_compiler(compiler))
        file = Path(f"{artifact.name}.fmu") if output is None else output
        file.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(artifact.path, file)
        out.print(f"{file}  {artifact.action} ({artifact.compiler})", highlight=False, soft_wrap=True)
        return
    if output is not None:
        raise InputError("--out is for a class of a --library of your own; recipes are copied to build/fmus.")
    with err.status("building"):
        for artifact in build(names or (), _compiler(compiler)):
            out.print(f"{artifact.path}  {artifact.action} ({artifact.compiler})", highlight=False, soft_wrap=True)


@app.command("list")
def list_command() -> None:
    """Show the recipes and which FMUs are there."""
    book = read_recipes()
    table = Table()
    for title in ("FMU", "class", "interfaces", "solver", "tolerance", "on disk"):
        table.add_column(title, no_wrap=True)
    for name, recipe in book.recipes.items():
        there = (OUTPUT / f"{name}.fmu").exists()
        table.add_row(
            name,
            recipe.class_name,
            " ".join(recipe.interfaces),
            recipe.solver,
            f"{recipe.tolerance:g}",
            "yes" if there else "no",
        )
    out.print(table)


@app.command("check")
def check_command(
    names: Names = None,
    compiler: Choice = "auto",
    update: Annotated[bool, typer.Option("--update", help="write lock.toml instead of comparing")] = False,
) -> None:
    """Validate FMUs against the FMI standard and compare them with lock.toml."""
    # Half a second of imports that no other command needs.
    from fmpy.validation import validate_fmu

    from railgrip.fmus.lock import LOCK, Entry, differences, read_lock, write_lock

    book = read_recipes()
    complaints: list[str] = []
    faces: dict[str, Entry] = {}
    actual = _compiler(compiler)
    for artifact in build(() if update else names or (), actual):
        complaints += [f"{artifact.name}.fmu: {problem}" for problem in validate_fmu(str(artifact.path))]
        # The lock file records the built-in compiler's view, whichever compiler made the FMU.
        faces[artifact.name] = artifact.face or translate(book[artifact.name])[1]
    if update:
        write_lock(book, faces)
        out.print(f"{LOCK} written", highlight=False)
    else:
        lock = read_lock()
        complaints += [f"{d.name}: {d.what}" for name, face in faces.items() for d in differences(name, lock, face)]
    for complaint in complaints:
        err.print(complaint, highlight=False, markup=False, soft_wrap=True)
    if complaints:
        raise typer.Exit(3)
    out.print(f"{len(faces)} FMUs are valid" + ("" if update else " and as lock.toml says"), highlight=False)


def main() -> None:
    """Run the command line; an error of ours ends in its sentence and its exit code."""
    try:
        app()
    except RailgripError as error:
        err.print(str(error), highlight=False, markup=False, soft_wrap=True)
        sys.exit(error.exit_code)


if __name__ == "__main__":
    main()
