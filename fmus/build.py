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

from fmus import lock, openmodelica
from fmus.errors import CompilerMissing, FmuError, WrongQuestion
from fmus.lock import Entry
from fmus.native import package, toolchain
from fmus.native.dae import read
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
        source: Digest of the C code and XML; the C compiler runs again only when it moved.
        compiler: native or openmodelica.
        face: The FMU as lock.toml records it; empty when OpenModelica built it.
    """

    inputs: str
    source: str
    compiler: str
    face: Entry


@dataclass(frozen=True, slots=True, kw_only=True)
class Built:
    """An FMU that is up to date.

    Attributes:
        action: built; unchanged, when Modelica files moved but the model did not; current, when nothing did.
        face: As in `Stamp`.
    """

    name: str
    path: Path
    compiler: str
    action: Action
    face: Entry


def fmu(name: str, compiler: Compiler = "auto", directory: Path = OUTPUT) -> Path:
    """Return the FMU of a recipe, built if it is not up to date.

    Raises:
        WrongQuestion: No such recipe, or the class does not compile.
        FmuError: A compiler is missing or fails.
    """
    return build_one(name, compiler, directory).path


def build_one(
    name: str, compiler: Compiler = "auto", directory: Path = OUTPUT, *, book: Cookbook | None = None,
    library: Path | None = None,
) -> Built:  # fmt: skip
    """Bring the FMU of one recipe up to date, from the library of its class unless another is given."""
    recipe = (read_recipes() if book is None else book)[name]
    library = library or recipe.library
    chosen = choose(compiler)
    path, stamp_file = directory / f"{name}.fmu", directory / f"{name}.json"
    stamp = _read_stamp(stamp_file) if path.exists() else None
    inputs = _inputs_digest(recipe, chosen, library)

    def done(action: Action, stamp: Stamp) -> Built:
        if action != "current":
            stamp_file.write_text(json.dumps(asdict(stamp)))
        return Built(name=name, path=path, compiler=chosen, action=action, face=stamp.face)

    if stamp is not None and stamp.inputs == inputs:
        return done("current", stamp)
    if chosen == "openmodelica":
        openmodelica.export(recipe, library, path)
        return done("built", Stamp(inputs=inputs, source=inputs, compiler=chosen, face={}))
    source, face = translate(recipe, library)
    key = source.digest + toolchain_digest()
    if stamp is not None and stamp.compiler == chosen and stamp.source == key:
        return done("unchanged", replace(stamp, inputs=inputs))
    package.pack(source, path)
    return done("built", Stamp(inputs=inputs, source=key, compiler=chosen, face=face))


def translate(recipe: Recipe, library: Path | None = None) -> tuple[package.Source, Entry]:
    """Return C code and XML of a recipe's FMU from the built-in compiler, and its face for lock.toml."""
    system = explicit(read(recipe.class_name, library or recipe.library))
    source = package.sources(
        system,
        interfaces=recipe.interfaces,
        solver=recipe.solver,
        tolerance=recipe.tolerance,
        step=recipe.step,
    )
    return source, lock.face(recipe, system, source.digest)


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
    yield from (build_one(name, compiler, directory) for name in wanted if name not in stale)
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
    return stamp is not None and stamp.inputs == _inputs_digest(book[name], choose(compiler), book[name].library)


def _read_stamp(file: Path) -> Stamp | None:
    """Return a stamp, or None when there is none that this version can read; then the FMU is built again."""
    try:
        return Stamp(**json.loads(file.read_text()))
    except (FileNotFoundError, json.JSONDecodeError, TypeError):
        return None


def _inputs_digest(recipe: Recipe, compiler: str, library: Path) -> str:
    native = compiler == "native"
    tool = _native_digest() + toolchain_digest() if native else openmodelica.version_line()
    return _digest([recipe.model_dump_json(), compiler, tool, _library_digest(library)])


def _library_digest(library: Path) -> str:
    """Return a digest over the names and contents of a library's Modelica files."""
    files = sorted(library.rglob("*.mo")) + sorted(library.rglob("package.order")) if library.is_dir() else [library]
    return _digest(part for file in files for part in (str(file.relative_to(library.parent)), file.read_text()))


@lru_cache(maxsize=1)
def _native_digest() -> str:
    """Return a digest over the built-in compiler itself and the packages it rests on."""
    native = ROOM / "native"
    files = sorted(file for file in native.rglob("*") if file.suffix in (".py", ".c", ".h", ".toml", ".jinja"))
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
