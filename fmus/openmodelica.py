"""The OpenModelica compiler: omc on the PATH, run on a script."""

import re
import shutil
import subprocess
import tempfile
from functools import lru_cache
from pathlib import Path

from fmus.errors import BuildFailed, CompilerMissing
from fmus.recipe import Recipe

TYPE = {frozenset({"me"}): "me", frozenset({"cs"}): "cs", frozenset({"me", "cs"}): "me_cs"}


def script(recipe: Recipe, library: Path) -> str:
    """Return the omc script that exports a recipe's FMU into the working folder.

    Every command prints its value. Errors come out of `getErrorString()`, because a failing command itself
    only answers false or "".
    """
    package = library / "package.mo" if library.is_dir() else library
    # Without the flag co-simulation is explicit Euler; the minus switches off the switching off, which is default.
    options = ["--fmiFlags=s:cvode"] if "cs" in recipe.interfaces else []
    kind = TYPE[frozenset(recipe.interfaces)]
    prefix = recipe.class_name.replace(".", "_")
    lines = [f'setCommandLineOptions("{option}");' for option in [*options, "-d=-disableDirectionalDerivatives"]]
    lines += [
        "getErrorString();",
        f'loadFile("{_escaped(str(package.resolve()))}");',
        "getErrorString();",
        f'buildModelFMU({recipe.class_name}, version="2.0", fmuType="{kind}", fileNamePrefix="{prefix}", '
        'platforms={"static"});',
        "getErrorString();",
        "",
    ]
    return "\n".join(lines)


def export(recipe: Recipe, library: Path, path: Path) -> Path:
    """Let omc build the FMU of a recipe.

    Raises:
        CompilerMissing: There is no omc on the PATH.
        BuildFailed: omc reports an error; the message carries its words.
    """
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        (folder / "export.mos").write_text(script(recipe, library))
        done = subprocess.run([_omc(), "export.mos"], cwd=folder, capture_output=True, text=True, check=False)
        made = folder / f"{recipe.class_name.replace('.', '_')}.fmu"
        problems = errors(done.stdout)
        if done.returncode or problems or not made.exists():
            said = "\n".join(problems) or (done.stdout + done.stderr).strip() or f"omc ended with {done.returncode}"
            raise BuildFailed(f"OpenModelica could not build {recipe.class_name}:\n{said}")
        path.parent.mkdir(parents=True, exist_ok=True)
        half = path.with_suffix(".part")
        shutil.copyfile(made, half)
        half.replace(path)
    return path


def errors(output: str) -> list[str]:
    """Return the error messages in what omc printed; notifications and warnings are none.

    A message reads `[file:line:column-line:column:writable] Error: text`, or `Error: text` without a place,
    and ends where the next one begins.
    """
    starts = re.compile(r'^"?(?:\[[^\]\n]*\] )?(Error|Warning|Notification): ', re.MULTILINE)
    found = list(starts.finditer(output))
    ends = [m.start() for m in found[1:]] + [len(output)]
    return [output[m.start() : end].strip(' "\n') for m, end in zip(found, ends, strict=False) if m[1] == "Error"]


@lru_cache(maxsize=1)
def version_line() -> str:
    """Return what `omc --version` prints.

    Raises:
        CompilerMissing: There is no omc on the PATH.
    """
    done = subprocess.run([_omc(), "--version"], capture_output=True, text=True, check=False)
    return done.stdout.strip()


def _omc() -> str:
    found = shutil.which("omc")
    if found is None:
        raise CompilerMissing("OpenModelica's omc is not on the PATH; install it or use --compiler native.")
    return found


def _escaped(text: str) -> str:
    return text.replace("\\", "/").replace('"', '\\"')
