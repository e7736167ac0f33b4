"""Command line: python -m railgrip.fmus build | list | check."""

import shutil
from pathlib import Path
from typing import Annotated, cast

import typer

from railgrip.console import answer, complain, progress, say, show_table
from railgrip.errors import InputError
from railgrip.fmus.build import OUTPUT, Compiler, build, build_class, translate
from railgrip.fmus.recipe import read_recipes
from railgrip.report.table import Table

app = typer.Typer(no_args_is_help=True, add_completion=False, help="Modelica classes to FMI 2.0 FMUs.")

Names = Annotated[list[str] | None, typer.Argument(help="FMUs of recipes.toml; all when none is named")]
Choice = Annotated[str, typer.Option(help="auto, openmodelica or native")]


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
        artifact = build_class(names[0], library, compiler=cast(Compiler, compiler))
        file = Path(f"{artifact.name}.fmu") if output is None else output
        file.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(artifact.path, file)
        say(f"{file}  {artifact.action} ({artifact.compiler})")
        return
    if output is not None:
        raise InputError("--out is for a class of a --library of your own; recipes are copied to build/fmus.")
    with progress("building"):
        for artifact in build(names or (), cast(Compiler, compiler)):
            say(f"{artifact.path}  {artifact.action} ({artifact.compiler})")


@app.command("list")
def list_command() -> None:
    """Show the recipes and which FMUs are there."""
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
    show_table(Table(rows, left=list(rows[0])))


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
    for artifact in build(() if update else names or (), cast(Compiler, compiler)):
        complaints += [f"{artifact.name}.fmu: {problem}" for problem in validate_fmu(str(artifact.path))]
        # The lock file records the built-in compiler's view, whichever compiler made the FMU.
        faces[artifact.name] = artifact.face or translate(book[artifact.name])[1]
    if update:
        write_lock(book, faces)
        say(f"{LOCK} written")
    else:
        lock = read_lock()
        complaints += [f"{d.name}: {d.what}" for name, face in faces.items() for d in differences(name, lock, face)]
    for complaint in complaints:
        complain(complaint)
    if complaints:
        raise typer.Exit(3)
    say(f"{len(faces)} FMUs are valid" + ("" if update else " and as lock.toml says"))


def main() -> None:
    """Run the command line."""
    answer(app)


if __name__ == "__main__":
    main()
