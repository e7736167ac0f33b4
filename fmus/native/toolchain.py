"""Shared libraries from C sources, with the system's compiler or else that of the `ziglang` wheel.

The structs that the headers of a library declare are Python objects.
"""

import hashlib
import importlib.util
import json
import os
import platform
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from pathlib import Path
from threading import Thread
from typing import Any, Final

import numpy as np
from cffi import FFI
from numpy.typing import NDArray

from railgrip.base.cache import find, keep, one_maker
from railgrip.base.errors import BuildFailed, CompilerMissing
from railgrip.base.files import scratch
from railgrip.base.programs import environment_of_programs, find_program, installation

# With -ffp-contract=off and without -ffast-math, results are equal to the bit on every x86-64 machine. gnu99 is C99
# without trigraphs, in which `??/` would be a backslash, even inside a string literal.
FLAGS = ("-std=gnu99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-ffp-contract=off", "-fno-math-errno")
FAST_BUILD = ("-O1",)
"""Flags for generated code: -O2 takes twice as long to compile its long functions, without a gain at run time."""

LONGEST = 900.0
"""Time limit of a C compiler [s]."""

SUFFIX = {"Windows": ".dll", "Darwin": ".dylib"}.get(platform.system(), ".so")


@dataclass(frozen=True, slots=True)
class Platform:
    """A platform for which shared libraries can be compiled on any machine.

    Attributes:
        zig: Name of the platform for the compiler in `ziglang`.
        suffix: Suffix of a shared library.
        folder: Folder of its binaries in an FMU for FMI 2; for FMI 3 it is the key in `TARGETS`.
    """

    zig: str
    suffix: str
    folder: str


TARGETS = {
    # The oldest C library that Python's wheels for Linux (manylinux) require.
    "x86_64-linux": Platform("x86_64-linux-gnu.2.17", ".so", "linux64"),
    "x86_64-windows": Platform("x86_64-windows-gnu", ".dll", "win64"),
    "x86_64-darwin": Platform("x86_64-macos", ".dylib", "darwin64"),
    "aarch64-darwin": Platform("aarch64-macos", ".dylib", "aarch64-darwin"),
}
"""Platforms by their names in FMI 3."""

WEB = Platform("wasm32-wasi", ".wasm", "")
"""Browsers; pointers have 4 bytes there."""


# -P: without it, Python would first look for ziglang in the current folder.
_ZIG = (sys.executable, "-P", "-m", "ziglang", "cc")


@dataclass(frozen=True, slots=True, kw_only=True)
class Compiler:
    """A C compiler as a command.

    Attributes:
        command: Words before the arguments, such as ("/usr/bin/cc",).
        version: First line of `--version`; part of every cache key.
    """

    command: tuple[str, ...]
    version: str


def compiler() -> Compiler:
    """Return the compiler named by CC, else cc, gcc or clang on the PATH, else `python -m ziglang cc`.

    On Windows only CC and ziglang are used, because programs named gcc or clang have different headers there.

    Raises:
        CompilerMissing: No compiler was found.
    """
    usual = () if SUFFIX == ".dll" else ("cc", "gcc", "clang")
    for name in filter(None, (os.environ.get("CC"), *usual)):
        words = name.split()
        path = find_program(words[0])
        if path:
            return _probe((path, *words[1:]))
    if importlib.util.find_spec("ziglang") is not None:
        return _probe(_ZIG)
    raise CompilerMissing(
        "no C compiler: neither CC, cc, gcc nor clang is on the PATH and the Python package ziglang "
        f"is not installed; install it with {installation('compiler')}."
    )


def shared_library(
    sources: Mapping[str, str],
    name: str,
    *,
    units: Sequence[str] = (),
    include: Sequence[Path] = (),
    flags: Sequence[str] = (),
) -> Path:
    """Return the path of a shared library in the user's cache, compiled unless the same build is already there.

    Args:
        sources: C sources, file name → text.
        name: Name of the library, without suffix.
        units: Names of the files to compile, every `.c` when empty; the other files are included in these.
        include: Folders with further headers; a change of their content alone does not cause a new build.
        flags: Further flags, after `FLAGS`.

    Raises:
        CompilerMissing: No C compiler was found.
        BuildFailed: The compiler reports an error; the message contains its first lines.
        InputError: The cache cannot be used.
    """
    cc, file = compiler(), name + SUFFIX
    options = _options(include, flags)
    inputs = json.dumps([cc.command, cc.version, options, [*units], sorted(sources.items())])
    key = hashlib.sha256(inputs.encode()).hexdigest()
    if found := find("libraries", key, file):
        return found
    with one_maker("libraries", key, name):  # the first stops of two processes need the same libraries at the same time
        return find("libraries", key, file) or keep(
            "libraries", key, file, binary(sources, name, units=units, include=include, flags=flags)
        )


def binary(
    sources: Mapping[str, str],
    name: str,
    *,
    units: Sequence[str] = (),
    include: Sequence[Path] = (),
    flags: Sequence[str] = (),
    target: Platform | None = None,
) -> bytes:
    """Return the content of a shared library, compiled; other arguments and errors are those of `shared_library`.

    Args:
        target: Platform of the library; this machine when absent.
    """
    cc = compiler() if target is None else _compiler_for(target)
    with scratch("build") as folder:
        for file, text in sources.items():
            (folder / file).write_text(text, encoding="utf-8")
        # Relative names only: an absolute path would end up in the library and change its bytes.
        suffix = SUFFIX if target is None else target.suffix
        output = name + suffix
        files = units or sorted(file for file in sources if file.endswith(".c"))
        options = [option for option in _options(include, flags) if _suits(suffix, option)]
        linking = _linking() if target is None else ("-lm", "-s")
        failure = f"{' '.join(cc.command)} could not compile {name}"
        if len(files) > 1:
            files = _objects([*cc.command, *options], files, folder, name, failure)
        code, errors = _run([*cc.command, *options, *files, "-o", output, *linking], folder, name)
        if code:
            raise BuildFailed(f"{failure}:\n{_head(errors)}")
        return (folder / output).read_bytes()


def static_library(sources: Mapping[str, str], name: str, *, units: Sequence[str], flags: Sequence[str] = ()) -> bytes:
    """Return the content of a static library for this machine; arguments and errors are those of `shared_library`.

    Raises:
        CompilerMissing: No C compiler was found, or no `ar`.
    """
    cc = compiler()
    archiver = _archiver_of(cc.command)
    if not archiver[0]:
        raise CompilerMissing("a static library takes the program `ar`, which comes with the C compiler (binutils).")
    with scratch("build") as folder:
        for file, text in sources.items():
            (folder / file).write_text(text, encoding="utf-8")
        failure = f"{cc.command[0]} could not make lib{name}.a"
        objects = _objects([*cc.command, *_options((), flags)], units, folder, name, failure)
        code, errors = _run([*archiver, "rcs", f"lib{name}.a", *objects], folder, name)
        if code:
            raise BuildFailed(f"{archiver[0]} could not make lib{name}.a:\n{_head(errors)}")
        return (folder / f"lib{name}.a").read_bytes()


def _archiver_of(compiler: Sequence[str]) -> tuple[str, ...]:
    # zig contains both: `zig ar` belongs to `zig cc`. Other commands may end with cc as well, such as `ccache cc`.
    if compiler[-1] == "cc" and Path("", *compiler[-2:-1]).stem in ("zig", "ziglang"):
        return (*compiler[:-1], "ar")
    return (find_program("ar") or "",)


def _compiler_for(target: Platform) -> Compiler:
    if importlib.util.find_spec("ziglang") is None:
        raise CompilerMissing(f"for {target.zig} ziglang is needed; install it with {installation('compiler')}.")
    # With a target, a query of its version would leave an object file in the current folder.
    zig = _probe(_ZIG)
    return replace(zig, command=(*zig.command, "-target", target.zig))


def _suits(suffix: str, option: str) -> bool:
    # Code for Windows is always position-independent, and the compiler refuses the option. A module of WebAssembly is
    # complete, not a shared library.
    unsuited = {".dll": ("-fPIC", "-fvisibility=hidden"), ".wasm": ("-fPIC", "-fvisibility=hidden", "-shared")}
    return option not in unsuited.get(suffix, ())


def _objects(command: Sequence[str], units: Sequence[str], folder: Path, name: str, failure: str) -> list[str]:
    # The names of the object files of several translation units, of which as many are compiled at a time as there are
    # cores. `failure` is the beginning of the message about the first unit that does not compile.
    objects = [f"{Path(unit).stem}.o" for unit in units]
    options = [option for option in command if option != "-shared"]
    running = set[subprocess.Popen[str]]()
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        try:
            jobs = [
                pool.submit(_run, [*options, "-c", unit, "-o", made], folder, name, running)
                for unit, made in zip(units, objects, strict=True)
            ]
            for job in jobs:
                while not wait([job], timeout=1.0).done:  # an endless wait misses an interruption right before it
                    pass
                code, errors = job.result()
                if code:
                    raise BuildFailed(f"{failure}:\n{_head(errors)}")
        except BaseException:
            ending = Thread(target=pool.shutdown, kwargs={"cancel_futures": True})
            ending.start()
            while ending.is_alive():  # a compiler may be about to start
                for process in [*running]:
                    _kill(process)
                ending.join(0.01)
            raise
    return objects


def _run(
    command: Sequence[str], folder: Path, name: str, running: set[subprocess.Popen[str]] | None = None
) -> tuple[int, str]:
    # The exit code and the messages of a command, which is in `running` while it runs. In a new session, so that child
    # processes of the compiler end with it.
    running = set() if running is None else running
    with subprocess.Popen(
        command,
        cwd=folder,
        env=environment_of_programs(),  # not the one of C, in which `dae` hides the user's cache folder from rumoca
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="replace",
        start_new_session=True,
    ) as process:
        running.add(process)
        try:
            _, errors = process.communicate(timeout=LONGEST)
        except BaseException as end:
            _kill(process)
            if isinstance(end, subprocess.TimeoutExpired):
                raise BuildFailed(
                    f"{command[0]} takes more than {LONGEST} s to compile {name}; divide the class, or give its arrays "
                    "fewer elements."
                ) from None
            raise
        finally:
            running.discard(process)
        return process.returncode, errors


def _kill(process: subprocess.Popen[str]) -> None:
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError):  # it has just ended
            os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()


def _options(include: Sequence[Path], flags: Sequence[str]) -> list[str]:
    return [*FLAGS, *flags, *(f"-I{folder}" for folder in include)]


def _linking() -> tuple[str, ...]:
    return ("-lm", "-s", "-Wl,--build-id=none") if platform.system() == "Linux" else ("-lm",)


@cache
def _probe(command: tuple[str, ...]) -> Compiler:
    try:
        process = subprocess.run(
            [*command, "--version"], capture_output=True, encoding="utf-8", errors="replace", check=False
        )
    except OSError as error:
        raise CompilerMissing(f"C compiler {' '.join(command)} does not start: {error}.") from error
    if process.returncode:
        raise CompilerMissing(f"C compiler {' '.join(command)} does not start: {_head(process.stderr)}")
    return Compiler(command=command, version=process.stdout.partition("\n")[0])


def _head(text: str) -> str:
    return "\n".join(text.splitlines()[:12])  # later errors usually follow from the first


WORD: Final = 8
"""Size of a pointer, and of every number in a struct [bytes]."""

_FORMATS: Final = {"double": "f8", "long long": "i8", "int": "i4"}


@cache
def kernel_library(package: str, name: str) -> "CLibrary":
    """Return the library of NAME.c and NAME.h in the folder `kernel` of a package, loaded once.

    Raises:
        railgrip.base.errors.CompilerMissing: No C compiler was found.
    """
    source, header = f"{name}.c", f"{name}.h"
    kernel = files(package) / "kernel"
    texts = {file: (kernel / file).read_text(encoding="utf-8") for file in (source, header)}
    return CLibrary(texts, name, [header])


class CLibrary:
    """A library compiled from C sources, with the functions, structs and enums that their headers declare.

    Attributes:
        path: Path of the shared library.
        functions: The declared functions and enums.
    """

    def __init__(self, sources: Mapping[str, str], name: str, headers: Sequence[str], constants: str = "") -> None:
        """Compile C sources, or load the library from the cache; see `shared_library`.

        Args:
            sources: File name → text.
            name: Name of the library.
            headers: Names of headers with the declarations that Python uses, in the order of their dependence.
            constants: Lines `#define NAME integer` that the headers use for sizes.

        Raises:
            railgrip.base.errors.CompilerMissing: No C compiler was found.
        """
        self.path = shared_library(sources, name)
        self._ffi: Any = FFI()
        self._doubles = self._ffi.typeof("double *")
        # cffi parses declarations, and no preprocessor lines except those in `constants`.
        lines = [line for header in headers for line in sources[header].splitlines() if not line.startswith("#")]
        self._ffi.cdef(constants + "\n".join(lines))
        self.functions: Any = self._ffi.dlopen(str(self.path))

    def address(self, name: str) -> int:
        """Return the address of a function."""
        return int(self._ffi.cast("uintptr_t", getattr(self.functions, name)))

    def doubles(self, array: NDArray[np.float64] | None) -> Any:
        """Return the address of a contiguous array, which the caller must keep alive during the call; null for None."""
        return self._ffi.cast(self._doubles, 0 if array is None else array.ctypes.data)

    def struct(self, name: str, **fields: Any) -> "Struct":
        """Return a struct of a type in the headers; `fields` are as for `Struct.set`, all others are zero."""
        return Struct(self._ffi, name, fields)

    def array(self, name: str, elements: Sequence["Struct"]) -> "Struct":
        """Return an array of copies of structs of a type in the headers, for a field that points to the first."""
        return _StructArray(self._ffi, name, elements)

    def records(self, name: str, count: int) -> NDArray[np.void]:
        """Return an array of `count` zeroed structs of a type in the headers, which has no pointers."""
        fields = self._ffi.typeof(name).fields
        dtype = np.dtype(
            {
                "names": [field for field, _ in fields],
                "formats": [_format(description.type) for _, description in fields],
                "offsets": [description.offset for _, description in fields],
                "itemsize": self._ffi.sizeof(name),
            }
        )
        return np.zeros(count, dtype=dtype)


class Struct:
    """A struct in C, which keeps the objects alive that its fields point to.

    Attributes:
        pointer: Pointer to the struct for functions of the library; its fields are read as `pointer.name`.
    """

    def __init__(self, ffi: Any, name: str, fields: Mapping[str, Any]) -> None:
        self._ffi, self._name = ffi, name
        self._types = {field: description.type for field, description in ffi.typeof(name).fields}
        self._fields: dict[str, Any] = {}
        self.pointer: Any = ffi.new(f"{name} *")
        self.set(**fields)

    @property
    def address(self) -> int:
        """Address of the struct."""
        return int(self._ffi.cast("uintptr_t", self.pointer))

    def set(self, **fields: Any) -> None:
        """Set fields.

        The value of a pointer is a contiguous array of its type, a Struct, an address, or None. The value of a nested
        array or struct is an array, a Struct or a list of these, which are copied. Any other field is a number.
        """
        for name, value in fields.items():
            self._fields[name] = value
            setattr(self.pointer, name, self._convert(self._types[name], value))

    def view(self, name: str) -> NDArray[np.float64]:
        """Return a field that is an array of doubles, sharing its memory."""
        return np.frombuffer(self._ffi.buffer(getattr(self.pointer, name)), dtype=np.float64)

    def target(self, name: str) -> Any:
        """Return the array or Struct that a pointer was set to."""
        return self._fields[name]

    def copy_with(self, *names: str, **changes: Any) -> "Struct":
        """Return a struct of the same type with the same values in these fields, or in all, and with `changes`."""
        fields = {name: value for name, value in self._fields.items() if name in names or not names}
        return Struct(self._ffi, self._name, fields | changes)

    @property
    def content(self) -> bytes:
        """Bytes of the struct."""
        return bytes(self._ffi.buffer(self.pointer))

    def bytes_of(self, value: Any) -> bytes:
        """Return the bytes of a nested array or struct."""
        return bytes(self._ffi.buffer(value))

    def targets(self) -> Iterator["Struct | NDArray[Any]"]:
        """Yield the structs and arrays that the struct, or a struct nested in it, points to."""
        for name, value in self._fields.items():
            within = self._types[name].kind not in ("pointer", "function")
            for entry in value if isinstance(value, list) else [value]:
                if isinstance(entry, Struct) and within:
                    yield from entry.targets()
                elif isinstance(entry, Struct) or (isinstance(entry, np.ndarray) and not within):
                    yield entry

    def pointers(self) -> dict[int, str]:
        """Return the index of each word that is a pointer, to data or a function → its field, `Type.field`."""
        return dict(self._pointers(self._ffi.typeof(self._name), 0))

    def _pointers(self, kind: Any, begin: int, field: str = "") -> Iterator[tuple[int, str]]:
        if kind.kind == "struct":
            for name, inner in kind.fields:
                yield from self._pointers(inner.type, begin + inner.offset, f"{kind.cname}.{name}")
        elif kind.kind == "array":
            for place in range(kind.length):
                yield from self._pointers(kind.item, begin + place * self._ffi.sizeof(kind.item), field)
        elif kind.kind in ("pointer", "function"):
            yield begin // WORD, field

    def _convert(self, kind: Any, value: Any) -> Any:
        if kind.kind not in ("pointer", "function"):
            if isinstance(value, list):
                return [self._convert(kind.item, each) for each in value]
            if isinstance(value, Struct):
                return value.pointer[0]
            return value.ravel().tolist() if isinstance(value, np.ndarray) else value
        if isinstance(value, Struct):
            return value.pointer
        address = value.ctypes.data if isinstance(value, np.ndarray) else value
        return self._ffi.cast(kind, address or 0)


class _StructArray(Struct):
    """Copies of structs of one type, one after the other; its fields are numbers."""

    def __init__(self, ffi: Any, name: str, elements: Sequence[Struct]) -> None:
        self._ffi, self._name = ffi, f"{name}[{len(elements)}]"
        self._fields = {str(place): element for place, element in enumerate(elements)}
        self._types = dict.fromkeys(self._fields, ffi.typeof(name))
        self.pointer = ffi.new(self._name, [element.pointer[0] for element in elements])


def _format(kind: Any) -> Any:
    if kind.kind == "array":
        return _format(kind.item), (kind.length,)
    return _FORMATS.get(kind.cname, "u8")
