"""The OpenModelica compiler: omc on the PATH, run on a script."""

import re
import shutil
import subprocess
import tempfile
import warnings
from functools import lru_cache
from pathlib import Path

from fmus.errors import BuildFailed, CompilerMissing
from fmus.recipe import Recipe

TOLERANCE = 1e-8
"""Of CVODE in a co-simulation FMU. omc takes it from the class, not from whoever runs the FMU, and an absolute error
is this times a nominal value that is mostly one, while a deflection is a millimetre and the twist of an axle 1e-5."""


def script(recipe: Recipe, library: Path) -> str:
    """Return the omc script that exports a recipe's FMU into the working folder.

    Co-simulation comes together with model exchange. Asked for `fmuType="cs"` alone, omc 1.22 to 1.27 adds the
    derivative of every output as an equation (`introduceOutputRealDerivatives` in SimCodeMain.mo); index reduction
    then makes states of outputs and takes inputs for constant, and trajectories are wrong (OpenModelica issues 9782
    and 9785).

    In co-simulation, state events are acted upon where a communication step ends, not where they happen.

    Every command prints its value. Errors come out of `getErrorString()`, because a failing command itself
    only answers false or "".
    """
    package = library / "package.mo" if library.is_dir() else library
    prefix = recipe.class_name.replace(".", "_")
    if "cs" in recipe.interfaces:
        # Without the flag co-simulation is explicit Euler. Plants have events, and nobody differentiates them.
        kind, option = "me_cs", "--fmiFlags=s:cvode"
        also = [f"addClassAnnotation({recipe.class_name}, annotate=experiment(Tolerance={TOLERANCE}));"]
    else:
        # The minus switches off the switching off, which is default.
        kind, option, also = "me", "-d=-disableDirectionalDerivatives", []
    lines = [
        f'setCommandLineOptions("{option}");',
        "getErrorString();",
        f'loadFile("{_escaped(str(package.resolve()))}");',
        *also,
        "getErrorString();",
        f'buildModelFMU({recipe.class_name}, version="2.0", fmuType="{kind}", fileNamePrefix="{prefix}", '
        'platforms={"static"});',
        "getErrorString();",
        "",
    ]
    return "\n".join(lines)


def export(recipe: Recipe, library: Path, path: Path) -> Path:
    """Let omc build the FMU of a recipe.

    omc packs the FMU last of all, so where there is one, it is whole. Errors that it reports beside it, such as
    directional derivatives that it could not find, become a warning.

    Raises:
        CompilerMissing: There is no omc on the PATH.
        BuildFailed: omc hands over no FMU; the message carries its words.
    """
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        (folder / "export.mos").write_text(script(recipe, library))
        done = subprocess.run(
            [_omc(), "export.mos"], cwd=folder, capture_output=True, text=True, errors="replace", check=False
        )
        made = folder / f"{recipe.class_name.replace('.', '_')}.fmu"
        problems = errors(done.stdout)
        if done.returncode or not made.exists():
            said = "\n".join(problems) or (done.stdout + done.stderr).strip() or f"omc ended with {done.returncode}"
            raise BuildFailed(f"OpenModelica could not build {recipe.class_name}:\n{said}")
        if problems:
            said = "\n".join(problems)
            warnings.warn(f"OpenModelica built {recipe.class_name}, but says:\n{said}", stacklevel=2)
        path.parent.mkdir(parents=True, exist_ok=True)
        half = path.with_suffix(".part")
        shutil.copyfile(made, half)
        half.replace(path)
    return path


def errors(output: str) -> list[str]:
    """Return the error messages in what omc printed; notifications and warnings are none.

    A message reads `[file:line:column-line:column:writable] Error: text`, or `Error: text` without a place,
    and ends where the next one begins. An error of omc itself is an `Internal error`.
    """
    starts = re.compile(r'^"?(?:\[[^\]\n]*\] )?(Internal error|Error|Warning|Notification): ', re.MULTILINE)
    found = list(starts.finditer(output))
    ends = [m.start() for m in found[1:]] + [len(output)]
    told = zip(found, ends, strict=False)
    return [output[m.start() : end].strip(' "\n') for m, end in told if m[1] in ("Error", "Internal error")]


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
