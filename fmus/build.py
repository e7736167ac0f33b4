"""FMUs from recipes, built only if they are out of date."""

import gc
import json
from collections.abc import Generator, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from railgrip.base import cache
from railgrip.base.errors import CompilerMissing, InputError, RailgripError
from railgrip.base.files import scratch, write_bytes
from railgrip.base.programs import find_program
from railgrip.base.tables import JsonObject
from railgrip.fmus import openmodelica
from railgrip.fmus.native import separate_process, toolchain
from railgrip.fmus.native.library import (
    compiler_digest,
    digest,
    is_trusted,
    library_of,
    name_of,
    require_class_name,
    sources_digest,
    used_paths,
    uses_digest,
)
from railgrip.fmus.recipe import Cookbook, FmiType, Recipe, read_recipes

if TYPE_CHECKING:
    from railgrip.fmus.native.package import Source

OUTPUT = Path("build") / "fmus"
"""Where `railgrip build` leaves copies, below the current folder; railgrip does not load FMUs from there."""

KIND = "fmus"
"""Folder of FMUs in the user's cache."""

Compiler = Literal["auto", "openmodelica", "native"]
Action = Literal["built", "unchanged", "current"]
JOBS = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Artifact:
    """An FMU that is up to date.

    Attributes:
        action: "built"; "unchanged" if Modelica files changed but the model did not; "current" if nothing changed.
        interface: Entry of the FMU in lock.toml; empty if OpenModelica built it.
    """

    name: str
    path: Path
    compiler: str
    action: Action
    interface: JsonObject


def fmu(name: str, compiler: Compiler = "auto") -> Path:
    """Return the FMU of a recipe in the user's cache, built if it is missing or out of date.

    Raises:
        InputError: No such recipe, or the class does not compile.
        RailgripError: A compiler is missing or fails.
    """
    return build_one(name, compiler).path


def build_one(
    name: str, compiler: Compiler = "auto", directory: Path | None = None, *, book: Cookbook | None = None,
    library: Path | None = None,
) -> Artifact:  # fmt: skip
    """Bring the FMU of one recipe up to date, from the library of its class unless another is given.

    Only FMUs in the user's cache count as up to date; `directory` gets a copy.
    """
    recipe = (read_recipes() if book is None else book)[name]
    return _up_to_date(
        _BuildOrder(
            name=name, recipe=recipe, library=library or recipe.library, compiler=choose(compiler), directory=directory
        )
    )


def build_class(
    class_name: str, library: Path | Sequence[Path], interface: FmiType = "cs", compiler: Compiler = "auto"
) -> Artifact:
    """Bring the FMU of a user's class up to date; its name is the last part of the name of the class.

    Args:
        class_name: Full name, such as `MyLib.MyTrain`.
        library: A library's folder or its `package.mo`, or a single `.mo` file; or several, of which one has the class.
            It may use RailBraking, and libraries in the folders of MODELICAPATH.
        interface: cs for a plant, me for a prediction, me_cs for one that a filter may step.
        compiler: See `choose`.

    Raises:
        InputError: The library or class does not exist, or does not compile.
        RailgripError: A compiler is missing or fails.
    """
    require_class_name(class_name)
    named = [library] if isinstance(library, Path) else [*library]
    libraries = [library_of(one.absolute()) for one in named]
    for one, given in zip(libraries, named, strict=True):
        if not (one / "package.mo" if one.is_dir() else one).is_file():
            raise InputError(
                f"{class_name}: there is no Modelica library {given}; give its package.mo, its folder or a .mo file."
            )
    own = next((one for one in libraries if name_of(one) == class_name.partition(".")[0]), libraries[0])
    return _up_to_date(
        _BuildOrder(
            name=class_name.rpartition(".")[2],
            recipe=Recipe.of_class(class_name, interface),
            library=own,
            others=tuple(one for one in libraries if one != own),
            compiler=choose(compiler),
            directory=None,
        )
    )


def _up_to_date(order: "_BuildOrder") -> Artifact:
    sources = uses_digest(order.library, order.others, order.recipe.class_name)
    inputs = _inputs_digest(order.recipe, order.compiler, sources)
    found = _current(order, inputs)
    if found is not None:
        return found
    with cache.one_maker(KIND, inputs, order.name):  # the processes of a campaign need the same FMU at the same time
        return _current(order, inputs) or _compile(order, inputs, _translation_of(order))


def translate(recipe: Recipe, library: Path | None = None, others: Sequence[Path] = ()) -> tuple["Source", JsonObject]:
    """Return C code and XML of a recipe's FMU from the built-in compiler, and its interface for lock.toml."""
    # CasADi, rumoca and scipy take half a second to import; when everything is up to date they are not needed.
    from railgrip.fmus.native import package
    from railgrip.fmus.native.dae import read
    from railgrip.fmus.native.system import explicit
    from railgrip.fmus.recipe import interface_of

    with _without_garbage_collection():
        system = explicit(read(recipe.class_name, library or recipe.library, others=others, complete=True))
        source = package.sources(
            system,
            interfaces=recipe.interfaces,
            solver=recipe.solver,
            tolerance=recipe.tolerance,
            step=recipe.step,
        )
        return source, interface_of(recipe, system, source.digest)


@contextmanager
def _without_garbage_collection() -> Generator[None]:
    # The collector would visit the millions of objects of a long train again and again, a fifth of the time; few of
    # them are in cycles.
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def build(
    names: Iterable[str] = (), compiler: Compiler = "auto", directory: Path | None = OUTPUT
) -> Iterator[Artifact]:
    """Bring FMUs up to date, all of them if none is named, and yield each when it is; `directory` gets copies.

    Modelica is translated in this thread, one class after the other in the order of recipes.toml, so that the library
    is read once; meanwhile `JOBS` C compilers compile translated classes.

    Raises:
        RailgripError: The first FMU that could not be built; builds that are already running are completed.
    """
    book = read_recipes()
    selection = list(names) or list(book.recipes)
    actual = choose(compiler)
    read = lru_cache(sources_digest)
    orders = [
        _BuildOrder(name=name, recipe=book[name], library=book[name].library, compiler=actual, directory=directory)
        for name in selection
    ]
    stale: list[tuple[_BuildOrder, str]] = []
    for order in orders:
        inputs = _inputs_digest(order.recipe, actual, read(order.library))
        if (current := _current(order, inputs)) is not None:
            yield current
        else:
            stale.append((order, inputs))
    running: set[Future[Artifact]] = set()
    with ThreadPoolExecutor(JOBS) as pool:
        try:
            for order, inputs in stale:
                with ExitStack() as held:
                    held.enter_context(cache.one_maker(KIND, inputs, order.name))
                    made = _current(order, inputs)
                    if made is None:
                        job = pool.submit(_compile, order, inputs, _translation_of(order))
                        running.add(job)
                        lock = held.pop_all()
                        job.add_done_callback(lambda _, lock=lock: lock.close())
                if made is not None:
                    yield made
                for job in [future for future in running if future.done()]:
                    running.remove(job)
                    yield job.result()
            for job in as_completed(running):
                yield job.result()
        except RailgripError:
            pool.shutdown(cancel_futures=True)
            raise


@dataclass(frozen=True, slots=True, kw_only=True)
class _BuildOrder:
    """An FMU to build: its recipe, library, further libraries and compiler, and the folder for a copy."""

    name: str
    recipe: Recipe
    library: Path
    others: tuple[Path, ...] = ()
    compiler: Literal["openmodelica", "native"]
    directory: Path | None

    def entry(self, source: str) -> Path | None:
        return cache.find(KIND, source, f"{self.name}.fmu")

    def artifact(self, action: Action, entry: Path, interface: JsonObject) -> Artifact:
        path = entry if self.directory is None else _copy(entry, self.directory)
        return Artifact(name=self.name, path=path, compiler=self.compiler, action=action, interface=interface)


_Translation = tuple["Source", JsonObject]


def _current(order: _BuildOrder, inputs: str) -> Artifact | None:
    file = cache.find(KIND, inputs, f"{order.name}.json")
    if file is None:
        return None
    stamp = json.loads(file.read_text(encoding="utf-8"))
    entry = order.entry(stamp["source"])
    return None if entry is None else order.artifact("current", entry, stamp["interface"])


def _translation_of(order: _BuildOrder) -> _Translation | None:
    if order.compiler != "native":
        return None
    if is_trusted(order.library):
        return translate(order.recipe, order.library)
    from railgrip.fmus.native.package import Source

    recipe = order.recipe.model_dump(by_alias=True)
    source, interface = separate_process.call(
        "translate", order.recipe.class_name, order.library, recipe=recipe, others=[str(one) for one in order.others]
    )
    return Source(**source | {"units": tuple(source["units"])}), interface


def translate_here(
    class_name: str, library: Path, recipe: JsonObject, others: Sequence[str] = ()
) -> tuple[JsonObject, JsonObject]:
    """Return the result of `translate` for a recipe as JSON values, for `separate_process`."""
    source, interface = translate(Recipe.model_validate(recipe), library, [Path(one) for one in others])
    return asdict(source) | {"units": list(source.units)}, interface


def _compile(order: _BuildOrder, inputs: str, translation: _Translation | None) -> Artifact:
    # The stamp of all inputs names the digest of C code and XML under which the FMU is kept, so that the C compiler
    # runs only when that digest changes.
    action, file = "built", f"{order.name}.fmu"
    if translation is None:
        kept_under, interface = inputs, JsonObject()
        with scratch("build") as folder:
            # A message names this file, so it must remain after the build: next to the copy, or in the cache.
            log = (order.directory or cache.folder() / KIND / inputs / "log") / f"{order.name}.log"
            further = used_paths(order.recipe.class_name, order.library, order.others)
            content = openmodelica.export(order.recipe, order.library, folder / file, log, further).read_bytes()
        entry = cache.keep(KIND, kept_under, file, content)
    else:
        from railgrip.fmus.native import package

        source, interface = translation
        kept_under = digest([source.digest, toolchain_digest()])
        entry = order.entry(kept_under)
        if entry is None:
            entry = cache.keep(KIND, kept_under, file, package.archive_bytes(source))
        else:
            action = "unchanged"
    stamp = {"source": kept_under, "interface": interface}
    cache.keep(KIND, inputs, f"{order.name}.json", json.dumps(stamp).encode())
    return order.artifact(action, entry, interface)


def _copy(entry: Path, directory: Path) -> Path:
    path, content = directory / entry.name, entry.read_bytes()
    if not path.is_file() or path.read_bytes() != content:
        write_bytes(path, content)
    return path


def choose(compiler: Compiler) -> Literal["openmodelica", "native"]:
    """Return the compiler to use; for "auto" OpenModelica if it is on the PATH, else the built-in one.

    Raises:
        CompilerMissing: OpenModelica was requested and is not on the PATH.
        InputError: The name of the compiler is unknown.
    """
    present = find_program("omc") is not None
    if compiler == "openmodelica" and not present:
        raise CompilerMissing(
            "OpenModelica was requested, but omc is not on the PATH; install it or use --compiler native."
        )
    if compiler == "auto":
        return "openmodelica" if present else "native"
    if compiler not in ("openmodelica", "native"):
        raise InputError(f"there is no compiler '{compiler}'; use auto, openmodelica or native.")
    return compiler


def _inputs_digest(recipe: Recipe, compiler: str, library: str) -> str:
    if compiler == "native":
        return digest([recipe.model_dump_json(), compiler, compiler_digest() + toolchain_digest(), library])
    return digest([openmodelica.recipe_digest(recipe), compiler, openmodelica.version_line(), library])


@lru_cache(maxsize=1)
def toolchain_digest() -> str:
    """Return a digest over the C compiler and its options."""
    actual = toolchain.compiler()
    return digest([*actual.command, actual.version, *toolchain.FLAGS, *toolchain.FAST_BUILD])
