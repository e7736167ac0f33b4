"""A shared library of C code, with the structs that its headers declare as Python objects."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import Any, Final

import numpy as np
from cffi import FFI
from numpy.typing import NDArray

from railgrip.fmus.native.toolchain import shared_library

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

    def __init__(
        self,
        sources: Mapping[str, str],
        name: str,
        headers: Sequence[str],
        constants: str = "",
        *,
        flags: Sequence[str] = (),
    ) -> None:
        """Compile C sources, or load the library from the cache; see `shared_library`.

        Args:
            sources: File name → text.
            name: Name of the library.
            headers: Names of headers with the declarations that Python uses, in the order of their dependence.
            constants: Lines `#define NAME integer` that the headers use for sizes.
            flags: Further flags of the C compiler.

        Raises:
            railgrip.base.errors.CompilerMissing: No C compiler was found.
        """
        self.path = shared_library(sources, name, flags=flags)
        self._ffi: Any = FFI()
        # cffi parses declarations, and no preprocessor lines except those in `constants`.
        lines = [line for header in headers for line in sources[header].splitlines() if not line.startswith("#")]
        self._ffi.cdef(constants + "\n".join(lines))
        self.functions: Any = self._ffi.dlopen(str(self.path))

    def doubles(self, array: NDArray[np.float64]) -> Any:
        """Return the address of a contiguous array, which the caller must keep alive during the call."""
        return self._ffi.cast("double *", array.ctypes.data)

    def struct(self, name: str, **fields: Any) -> "Struct":
        """Return a struct of a type in the headers; `fields` are as for `Struct.set`, all others are zero."""
        return Struct(self._ffi, name, fields)

    def records(self, name: str, count: int) -> NDArray[np.void]:
        """Return an array of `count` zeroed structs of a type in the headers; pointers in them are addresses."""
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

    def _pointers(self, kind: Any, begin: int) -> Iterator[tuple[int, str]]:
        for name, field in kind.fields:
            inner, count = field.type, 1
            if inner.kind == "array":
                inner, count = inner.item, inner.length
            first, size = begin + field.offset, self._ffi.sizeof(inner)
            for place in range(first, first + count * size, size):
                if inner.kind == "struct":
                    yield from self._pointers(inner, place)
                elif inner.kind in ("pointer", "function"):
                    yield place // WORD, f"{kind.cname}.{name}"

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


def _format(kind: Any) -> Any:
    if kind.kind == "array":
        return _format(kind.item), (kind.length,)
    return _FORMATS.get(kind.cname, "u8")
