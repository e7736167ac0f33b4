"""A shared library of our C with the structs of its headers, each written there and nowhere else."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import Any, Final

import numpy as np
from cffi import FFI
from numpy.typing import NDArray

from railgrip.fmus.native.toolchain import shared_library

WORD: Final = 8
"""Bytes of a pointer, and of every number in a struct."""

_FORMATS: Final = {"double": "f8", "long long": "i8", "int": "i4"}


@cache
def kernel_library(package: str, name: str) -> "CLibrary":
    """Return the library of NAME.c and NAME.h in the folder `kernel` of a package, loaded once.

    Raises:
        railgrip.base.errors.CompilerMissing: There is no C compiler.
    """
    source, header = f"{name}.c", f"{name}.h"
    kernel = files(package) / "kernel"
    texts = {file: (kernel / file).read_text(encoding="utf-8") for file in (source, header)}
    return CLibrary(texts, name, [header])


class CLibrary:
    """C sources, compiled or found compiled, with the functions, structs and enums that their headers declare.

    Attributes:
        path: Of the shared library.
        functions: Those declared, and their enums.
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
        """Compile `sources`, file name to text, as for `shared_library`.

        Args:
            headers: Headers with the declarations that Python uses, in the order of their dependence.
            constants: Lines `#define NAME integer` that they use for sizes.

        Raises:
            railgrip.base.errors.CompilerMissing: There is no C compiler.
        """
        self.path = shared_library(sources, name, flags=flags)
        self._ffi: Any = FFI()
        # cffi reads declarations and sizes, and knows no other preprocessor.
        lines = [line for header in headers for line in sources[header].splitlines() if not line.startswith("#")]
        self._ffi.cdef(constants + "\n".join(lines))
        self.functions: Any = self._ffi.dlopen(str(self.path))

    def doubles(self, array: NDArray[np.float64]) -> Any:
        """Return the address of a contiguous array that outlives the call."""
        return self._ffi.cast("double *", array.ctypes.data)

    def struct(self, name: str, **fields: Any) -> "Struct":
        """Return a struct of a type of the headers; `fields` are as for `Struct.set`, others are zero."""
        return Struct(self._ffi, name, fields)

    def records(self, name: str, count: int) -> NDArray[np.void]:
        """Return an array of zeroed structs of a type of the headers; pointers in it are addresses."""
        fields = self._ffi.typeof(name).fields
        dtype = np.dtype(
            {
                "names": [field for field, _ in fields],
                "formats": [_FORMATS.get(description.type.cname, "u8") for _, description in fields],
                "offsets": [description.offset for _, description in fields],
                "itemsize": self._ffi.sizeof(name),
            }
        )
        return np.zeros(count, dtype=dtype)


class Struct:
    """A struct in C; what its fields point to lives as long as it does.

    Attributes:
        pointer: To it, for functions of the library; its fields are read as `pointer.name`.
    """

    def __init__(self, ffi: Any, name: str, fields: Mapping[str, Any]) -> None:
        self._ffi, self._name = ffi, name
        self._types = {field: description.type for field, description in ffi.typeof(name).fields}
        self._fields: dict[str, Any] = {}
        self.pointer: Any = ffi.new(f"{name} *")
        self.set(**fields)

    @property
    def address(self) -> int:
        """Of the struct."""
        return int(self._ffi.cast("uintptr_t", self.pointer))

    def set(self, **fields: Any) -> None:
        """Set fields.

        A pointer takes a contiguous array of its type, a Struct, an address, or None; a nested array or struct takes an
        array, a Struct or a list of these, which are copied; any other member takes a number.
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
        """Return a struct of the same type with the same in these fields, or in all, but for changes."""
        fields = {name: value for name, value in self._fields.items() if name in names or not names}
        return Struct(self._ffi, self._name, fields | changes)

    @property
    def content(self) -> bytes:
        """Its bytes."""
        return bytes(self._ffi.buffer(self.pointer))

    def targets(self) -> Iterator["Struct | NDArray[Any]"]:
        """Yield structs and arrays that it points to, and those that structs within it point to."""
        for name, value in self._fields.items():
            within = self._types[name].kind not in ("pointer", "function")
            for entry in value if isinstance(value, list) else [value]:
                if isinstance(entry, Struct) and within:
                    yield from entry.targets()
                elif isinstance(entry, Struct) or (isinstance(entry, np.ndarray) and not within):
                    yield entry

    def pointers(self) -> dict[int, str]:
        """Return the words that are pointers, to functions too, and the field `Type.field` that each is."""
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
