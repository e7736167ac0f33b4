"""The OpenModelica compiler: omc on the PATH, run on a script."""

import re
import shutil
import signal
import subprocess
import sys
import warnings
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

from railgrip.base.cache import private_folder
from railgrip.base.errors import BuildFailed, CompilerMissing
from railgrip.base.files import scratch, write_bytes
from railgrip.base.programs import environment_of_programs, find_program
from railgrip.fmus.native.library import LIBRARY, digest
from railgrip.fmus.recipe import Recipe

TOLERANCE = 1e-8
"""Tolerance of CVODE in a co-simulation FMU, which omc reads from the class, not from the importer of the FMU. The
absolute error is this times the nominal value of a state, 1e5 for a pressure, 1e-3 for a deflection."""

REQUIRED = ("cmake", "make", "zip")
"""Programs that omc starts to compile and pack an FMU; on Windows it has its own."""

_JOBS = 2
"""C compilers that one omc runs at the same time; without a number it runs one for each of a hundred files."""

_LAUNCHER = """\
for argument; do
  shift
  case $argument in
    *.c) unit=$argument ;;
    -[Ofm]*) options="$options $argument" ;;
  esac
  test "$previous" != -o || object=$argument
  previous=$argument
  set -- "$@" "$argument"
done
case $unit in
  */sources/*/*.c)
    if command -v sha256sum > /dev/null && "$@" -E -P; then
      key=$({ echo "$options"; "$1" --version; sed "s|${unit%/sources/*}||g" "$object"; } | sha256sum)
      kept=$RAILGRIP_OBJECTS/${key%% *}
      cp "$kept/unit.o" "$object" 2> /dev/null && exec touch "$kept/unit.o"
      "$@" || exit
      mkdir -p "$kept" && cp "$object" "$kept/$$.o" && mv "$kept/$$.o" "$kept/unit.o"
      exit 0
    fi ;;
  *.c) test "$(wc -c < "$unit")" -lt 1000000 || set -- "$@" -O1 ;;
esac
exec "$@"
"""
"""Keeps the objects of omc's runtime, hundred files that are compiled into each FMU and are the same in nearly all,
under the digest of options, compiler and preprocessed text, without the name of the temporary folder.

Units of the model itself that have a megabyte and more, which only set start values and parameters, are compiled with
-O1: GCC takes minutes for them with -O3. Of several such options GCC and Clang use the last."""

_LINES = 12
"""Maximum number of lines of a build log in a message."""
_UNSET = re.compile(
    r"Parameter \S+\.\S+ has (?:no value\b.*\busing available start|neither value nor start) value", re.DOTALL
)
_TELLING = re.compile(
    r"\berror\b|undefined reference|not found|no such file|cannot|segmentation fault|\bassert", re.IGNORECASE
)


def script(recipe: Recipe, library: Path, *, derivatives: bool, further: Sequence[Path] = ()) -> str:
    """Return the omc script that exports a recipe's FMU into the working folder.

    Co-simulation is exported together with model exchange. With `fmuType="cs"` alone, omc 1.22 to 1.27 adds the
    derivative of every output as an equation (introduceOutputRealDerivatives in SimCodeMain.mo); index reduction then
    turns outputs into states and treats inputs as constant, so that trajectories are wrong (OpenModelica issues 9782
    and 9785).

    In co-simulation, state events take effect at the end of a communication step, not when they occur.

    Every command prints its value. Errors are read with `getErrorString()`, because a failing command itself only
    returns false or "".

    Args:
        recipe: Recipe of the FMU.
        library: Folder of the Modelica library, or its only file.
        derivatives: Whether directional derivatives are requested.
        further: Libraries that it uses besides RailBraking, likewise.
    """
    packages = [path / "package.mo" if path.is_dir() else path for path in (*further, library)]
    if library != LIBRARY:
        packages.insert(0, LIBRARY / "package.mo")  # any library may use RailBraking
    options, build = _commands(recipe, derivatives=derivatives)
    # Without its class, buildModelFMU would report a dozen further errors about a package of that name.
    loaded = [f'loaded{k} := loadFile("{_escape(str(path.resolve()))}");' for k, path in enumerate(packages)]
    condition = " and ".join(f"loaded{k}" for k in range(len(packages)))
    lines = [*options, "getErrorString();", *loaded, "getErrorString();", f"if {condition} then"]
    return "\n".join([*lines, *build, "end if;", "getErrorString();", ""])


def recipe_digest(recipe: Recipe) -> str:
    """Return the digest of everything in a recipe that the FMU of omc depends on.

    The FMU of a recipe for co-simulation is the same as that for both interfaces.
    """
    return digest([str(_commands(recipe, derivatives=not _is_plant(recipe))), _LAUNCHER])


def _is_plant(recipe: Recipe) -> bool:
    return "cs" in recipe.interfaces and not recipe.restarts


def _commands(recipe: Recipe, *, derivatives: bool) -> tuple[list[str], list[str]]:
    kind, options, build = "me", [], []
    if "cs" in recipe.interfaces:
        kind = "me_cs"
        options = ["--fmiFlags=s:cvode"]  # without it, explicit Euler
        if recipe.restarts:
            options.append("-d=fmuExperimental")  # fmi2GetFMUstate and fmi2SetFMUstate
        build = [f"addClassAnnotation({recipe.class_name}, annotate=experiment(Tolerance={TOLERANCE}));"]
    if derivatives:
        options.append("-d=-disableDirectionalDerivatives")  # omc disables them by default
    prefix = recipe.class_name.replace(".", "_")
    build.append(
        f'buildModelFMU({recipe.class_name}, version="2.0", fmuType="{kind}", fileNamePrefix="{prefix}", '
        'platforms={"static"});'
    )
    return [f'setCommandLineOptions("{option}");' for option in options], build


def export(recipe: Recipe, library: Path, path: Path, log: Path | None = None, further: Sequence[Path] = ()) -> Path:
    """Build the FMU of a recipe with omc, and return its path.

    omc packs the FMU last, so an existing FMU is complete; messages of omc in addition to it become a warning. A
    parameter of a component without a value fails the build, because omc would use its start value, as if a modifier
    were lost. Directional derivatives are requested if a filter may use them, that is not for plants. omc (up to
    1.28) fails on them for some functions with array arguments, so the build is repeated without them.

    Args:
        recipe: Recipe of the FMU.
        library: Folder of the Modelica library, or its only file.
        path: Path of the FMU.
        log: File for long messages of omc; next to the FMU unless given.
        further: Libraries that it uses besides RailBraking, as folders or files.

    Raises:
        CompilerMissing: omc or a program that it needs is not on the PATH.
        BuildFailed: omc built no FMU, or one with parameters without a value; the message quotes omc, with a long log
            of the C compiler shortened.
    """
    log = log or path.with_suffix(".log")
    if find_program("omc") and (missing := missing_programs()):
        raise CompilerMissing(
            f"OpenModelica cannot build {recipe.class_name}: its omc needs {' and '.join(missing)}, which the PATH "
            "does not have; install them or use --compiler native."
        )
    messages: list[str] = []
    is_plant = _is_plant(recipe)
    for derivatives in (False,) if is_plant else (True, False):
        with scratch("build") as folder:
            fmu, message = _run(script(recipe, library, derivatives=derivatives, further=further), recipe, folder)
            messages += [message] if message else []
            if fmu is None:
                continue
            write_bytes(path, fmu.read_bytes())
        if messages:
            how = "" if derivatives or is_plant else " without directional derivatives"
            words = _excerpt(messages[0], log)
            warnings.warn(f"OpenModelica built {recipe.class_name}{how}, but reports:\n{words}", stacklevel=2)
        return path
    words = _excerpt(messages[-1], log)
    raise BuildFailed(f"OpenModelica could not build {recipe.class_name}:\n{words}")


def missing_programs() -> list[str]:
    """Return the programs that omc needs to build an FMU and that are not on the PATH."""
    return [] if sys.platform == "win32" else [name for name in REQUIRED if find_program(name) is None]


def _excerpt(text: str, log: Path) -> str:
    # When the C compiler fails, omc passes on all that make and the compiler printed as one message.
    lines = text.splitlines()
    if len(lines) <= _LINES:
        return text
    log.parent.mkdir(parents=True, exist_ok=True)
    log.write_text(text + "\n", encoding="utf-8")
    telling = [line for line in lines[1:] if _TELLING.search(line)] or lines[1 - _LINES :]
    return "\n".join([lines[0], *telling[: _LINES - 1], f"All {len(lines)} lines are in {log}."])


def _run(text: str, recipe: Recipe, folder: Path) -> tuple[Path | None, str]:
    (folder / "export.mos").write_text(text, encoding="utf-8")
    process = _call(f"-n={_JOBS}", "export.mos", folder=folder)
    fmu = folder / f"{recipe.class_name.replace('.', '_')}.fmu"
    open_parameters = "\n".join(unset(process.stdout))
    if open_parameters:
        raise BuildFailed(f"OpenModelica uses start values of {recipe.class_name} as values:\n{open_parameters}")
    problems = "\n".join(errors(process.stdout))
    if process.returncode == 0 and fmu.exists():
        return fmu, problems
    printed = problems or (process.stdout + process.stderr).strip()
    if process.returncode == 0:
        return None, printed or "omc ended with 0 and built no FMU"
    # A crash leaves the values of the first commands, `true`, which say nothing.
    return None, f"omc ended with {_end(process.returncode)}\n{printed}".strip()


def _end(code: int) -> str:
    if code >= 0:
        return f"exit status {code}"
    try:
        return f"signal {signal.Signals(-code).name}"
    except ValueError:
        return f"signal {-code}"


def errors(output: str) -> list[str]:
    """Return the error messages in the output of omc; an error of omc itself is an `Internal error`."""
    return [text for kind, text in _messages(output) if kind in ("Error", "Internal error")]


def unset(output: str) -> list[str]:
    """Return the warnings about component parameters without a value; the importer sets the other parameters."""
    return [text for kind, text in _messages(output) if kind == "Warning" and _UNSET.search(text)]


def _messages(output: str) -> list[tuple[str, str]]:
    # A message is `[file:line:column-line:column:writable] Error: text`, or `Error: text` without a place, and ends
    # where the next one begins.
    starts = re.compile(r'^"?(?:\[[^\]\n]*\] )?(Internal error|Error|Warning|Notification): ', re.MULTILINE)
    matches = list(starts.finditer(output))
    ends = [m.start() for m in matches[1:]] + [len(output)]
    return [(m[1], output[m.start() : end].strip(' "\n')) for m, end in zip(matches, ends, strict=False)]


@lru_cache(maxsize=1)
def version_line() -> str:
    """Return the output of `omc --version`.

    Raises:
        CompilerMissing: omc is not on the PATH.
    """
    return _call("--version").stdout.strip()


def _call(*arguments: str, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    path = find_program("omc")
    if path is None:
        raise CompilerMissing("OpenModelica's omc is not on the PATH; install it or use --compiler native.")
    environment = environment_of_programs()
    if folder is not None and (shell := shutil.which("sh", path=environment["PATH"])):
        (folder / "launcher.sh").write_text(_LAUNCHER, encoding="utf-8")
        environment.setdefault("CMAKE_C_COMPILER_LAUNCHER", f"{shell};{folder / 'launcher.sh'}")
        environment["RAILGRIP_OBJECTS"] = str(private_folder("objects", "openmodelica"))
    return subprocess.run(
        [path, *arguments], cwd=folder, capture_output=True, encoding="utf-8", errors="replace", check=False,
        env=environment,
    )  # fmt: skip


def _escape(text: str) -> str:
    return text.replace("\\", "/").replace('"', '\\"')
