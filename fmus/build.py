"""From recipe to FMU, doing only what has to be done again."""

import hashlib
import json
import shutil
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from importlib.metadata import version
from multiprocessing import get_context
from pathlib import Path
from typing import Literal

from fmus import openmodelica
from fmus.errors import CompilerMissing, FmuError, WrongQuestion
from fmus.native import package, toolchain
from fmus.native.dae import LIBRARY, read
from fmus.native.system import explicit
from fmus.recipe import Cookbook, Recipe, read_recipes

ROOM = Path(__file__).parent
OUTPUT = ROOM.parent / "build" / "fmus"

Compiler = Literal["auto", "openmodelica", "native"]
Action = Literal["built", "unchanged", "current"]
JOBS = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Stamp:
    """What an FMU on disk was made from, kept beside it as NAME.json.

    Attributes:
        inputs: Digest of everything that was read: Modelica files, recipe, compiler.
        source: Digest of what came out of the compiler's front half; the C compiler runs again only when it moved.
        compiler: native or openmodelica.
    """

    inputs: str
    source: str
    compiler: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Built:
    """An FMU that is up to date.

    Attributes:
        action: built; unchanged, when Modelica files moved but the model did not; current, when nothing did.
    """

    name: str
    path: Path
    compiler: str
    action: Action


def fmu(name: str, compiler: Compiler = "auto", directory: Path = OUTPUT) -> Path:
    """Return the FMU of a recipe, built if it is not up to date.

    Raises:
        WrongQuestion: No such recipe, or the class does not compile.
        FmuError: A compiler is missing or fails.
    """
    return build_one(name, compiler, directory).path


def build_one(
    name: str, compiler: Compiler = "auto", directory: Path = OUTPUT, *, book: Cookbook | None = None,
    library: Path = LIBRARY,
) -> Built:  # fmt: skip
    """Bring the FMU of one recipe up to date."""
    recipe = (read_recipes() if book is None else book)[name]
    chosen = choose(compiler)
    path, stamp_file = directory / f"{name}.fmu", directory / f"{name}.json"
    stamp = _read_stamp(stamp_file) if path.exists() else None
    inputs = _inputs_digest(recipe, chosen, library)
    if stamp is not None and stamp.inputs == inputs:
        return Built(name=name, path=path, compiler=chosen, action="current")
    if chosen == "openmodelica":
        openmodelica.export(recipe, library, path)
        stamp_file.write_text(json.dumps(asdict(Stamp(inputs=inputs, source=inputs, compiler=chosen))))
        return Built(name=name, path=path, compiler=chosen, action="built")
    source = native_source(recipe, library)
    if stamp is not None and stamp.compiler == chosen and stamp.source == source.digest + toolchain_digest():
        stamp_file.write_text(json.dumps(asdict(replace(stamp, inputs=inputs))))
        return Built(name=name, path=path, compiler=chosen, action="unchanged")
    # The C compiler is asked for first, so that its absence is told before anything is removed.
    package.pack(source, path)
    fresh = Stamp(inputs=inputs, source=source.digest + toolchain_digest(), compiler=chosen)
    stamp_file.write_text(json.dumps(asdict(fresh)))
    return Built(name=name, path=path, compiler=chosen, action="built")


def native_source(recipe: Recipe, library: Path = LIBRARY) -> package.Source:
    """Return C code and XML of a recipe's FMU from the built-in compiler."""
    return package.sources(
        explicit(read(recipe.class_name, library)),
        interfaces=recipe.interfaces,
        solver=recipe.solver,
        tolerance=recipe.tolerance,
        step=recipe.step,
    )


def build(
    names: Iterable[str] = (), compiler: Compiler = "auto", directory: Path = OUTPUT, *, jobs: int = JOBS
) -> Iterator[Built]:
    """Bring FMUs up to date, all of them when none is named, and yield each when it is.

    Raises:
        FmuError: The first one that could not be built; those begun before it still finish.
    """
    book = read_recipes()
    wanted = list(names) or list(book.recipes)
    for name in wanted:
        book[name]
    stale = [name for name in wanted if not _is_current(name, book, compiler, directory)]
    for name in wanted:
        if name not in stale:
            yield Built(
                name=name, path=directory / f"{name}.fmu", compiler=choose(compiler), action="current"
            )
    if len(stale) <= 1:
        yield from (build_one(name, compiler, directory) for name in stale)
        return
    # Largest first, in file order otherwise: plants lead recipes.toml. Spawned, because CasADi holds threads.
    with ProcessPoolExecutor(min(jobs, len(stale)), mp_context=get_context("spawn")) as pool:
        running: list[Future[Built]] = [pool.submit(build_one, name, compiler, directory) for name in stale]
        try:
            for done in as_completed(running):
                yield done.result()
        except FmuError:
            pool.shutdown(cancel_futures=True)
            raise


def choose(compiler: Compiler) -> Literal["openmodelica", "native"]:
    """Return the compiler to use: OpenModelica when it is on the PATH, unless one is asked for.

    Raises:
        CompilerMissing: OpenModelica was asked for and is not there.
        WrongQuestion: There is no compiler of that name.
    """
    present = shutil.which("omc") is not None
    if compiler == "openmodelica" and not present:
        raise CompilerMissing(
            "OpenModelica was asked for, but omc is not on the PATH; install it or use --compiler native."
        )
    if compiler == "auto":
        return "openmodelica" if present else "native"
    if compiler not in ("openmodelica", "native"):
        raise WrongQuestion(f"there is no compiler '{compiler}'; use auto, openmodelica or native.")
    return compiler


def _is_current(name: str, book: Cookbook, compiler: Compiler, directory: Path) -> bool:
    stamp = _read_stamp(directory / f"{name}.json") if (directory / f"{name}.fmu").exists() else None
    return stamp is not None and stamp.inputs == _inputs_digest(book[name], choose(compiler), LIBRARY)


def _read_stamp(file: Path) -> Stamp | None:
    """Return a stamp, or None when there is none that this version can read; then the FMU is built again."""
    try:
        return Stamp(**json.loads(file.read_text()))
    except (FileNotFoundError, json.JSONDecodeError, TypeError):
        return None


def _inputs_digest(recipe: Recipe, compiler: str, library: Path) -> str:
    if compiler == "openmodelica":
        tool = openmodelica.version_line()
    else:
        tool = _native_digest() + toolchain_digest()
    return _digest([recipe.model_dump_json(), compiler, tool, _library_digest(library)])


def _library_digest(library: Path) -> str:
    """Return a digest over the names and contents of a library's Modelica files."""
    files = (
        sorted(library.rglob("*.mo")) + sorted(library.rglob("package.order"))
        if library.is_dir()
        else [library]
    )
    return _digest(
        part for file in files for part in (str(file.relative_to(library.parent)), file.read_text())
    )


@lru_cache(maxsize=1)
def _native_digest() -> str:
    """Return a digest over the built-in compiler itself and the packages it rests on."""
    native = ROOM / "native"
    files = sorted(
        file for file in native.rglob("*") if file.suffix in (".py", ".c", ".h", ".toml", ".jinja")
    )
    return _digest([version("rumoca"), version("casadi"), *(file.read_text() for file in files)])


@lru_cache(maxsize=1)
def toolchain_digest() -> str:
    """Return a digest over the C compiler and its options."""
    chosen = toolchain.compiler()
    return _digest([*chosen.command, chosen.version, *toolchain.FLAGS, *package.FLAGS])


def _digest(parts: Iterable[str]) -> str:
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part.encode() + b"\0")
    return digest.hexdigest()
