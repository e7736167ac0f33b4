"""The loop's own code in C, compiled once on a machine: its functions and structs, and formulas as functions in C."""

import ctypes
from functools import cache
from importlib.resources import files
from typing import Any, Final

import casadi as ca
import numpy as np
from cffi import FFI
from numpy.typing import NDArray

from railgrip.fmus.native.toolchain import shared_library
from railgrip.signals import Layout

KERNEL: Final = files("railgrip.loop") / "kernel"
_HEADERS: Final = ("sensors.h", "plausible.h", "driver.h", "rail.h", "faults.h", "cycle.h")


class Kernel:
    """The sensors, plausibility checks, driver, rail, faults and cycle in C, for the vectors of one layout.

    Attributes:
        ffi: Knows the types of the headers.
        functions: Those that the headers declare, and their enums.
    """

    def __init__(self, layout: Layout) -> None:
        """Compile them, or find them compiled.

        Raises:
            railgrip.errors.CompilerMissing: There is no C compiler.
        """
        headers = {name: (KERNEL / name).read_text(encoding="utf-8") for name in _HEADERS}
        codes = [name.replace(".h", ".c") for name in _HEADERS]
        sources = headers | {name: (KERNEL / name).read_text(encoding="utf-8") for name in ("export.h", *codes)}
        constants, formation = layout.header(), layout.formation
        name = f"cycle_{formation.groups}_{formation.wheelsets}"
        library = shared_library(sources | {"layout.h": constants}, name)
        self.ffi: Any = FFI()
        # cffi reads declarations and sizes, and knows no other preprocessor.
        lines = [line for header in headers.values() for line in header.splitlines() if not line.startswith("#")]
        self.ffi.cdef(constants + "\n".join(lines))
        self.functions: Any = self.ffi.dlopen(str(library))

    def doubles(self, array: NDArray[np.float64]) -> Any:
        """Return the address of a contiguous array that outlives the call."""
        return self.ffi.cast("double *", array.ctypes.data)


@cache
def kernel(layout: Layout) -> Kernel:
    """Return the loop's code in C for vectors of this layout.

    Raises:
        railgrip.errors.CompilerMissing: There is no C compiler.
    """
    return Kernel(layout)


class Struct:
    """A struct of the loop in C; what its fields point to lives as long as it does.

    Attributes:
        pointer: To it, for functions of the kernel; its fields are read as `pointer.name`.
    """

    def __init__(self, layout: Layout, name: str, **fields: Any) -> None:
        """Make a struct of the type `name` of the headers; `fields` are as for `set`, others are zero."""
        self._ffi = kernel(layout).ffi
        self._types = {field: description.type for field, description in self._ffi.typeof(name).fields}
        self._targets: dict[str, Any] = {}
        self.pointer: Any = self._ffi.new(f"{name} *")
        self.set(**fields)

    def set(self, **fields: Any) -> None:
        """Set fields.

        A pointer takes a contiguous array of what it points to, a Struct, an address, or None; an array or a struct
        within takes an array, a Struct or a list of these, which are copied; what is left takes a number.
        """
        for name, value in fields.items():
            self._targets[name] = value
            setattr(self.pointer, name, self._converted(self._types[name], value))

    def view(self, name: str) -> NDArray[np.float64]:
        """Return a field that is an array of doubles, sharing its memory."""
        return np.frombuffer(self._ffi.buffer(getattr(self.pointer, name)), dtype=np.float64)

    def _converted(self, kind: Any, value: Any) -> Any:
        if kind.kind not in ("pointer", "function"):
            if isinstance(value, list):
                return [self._converted(kind.item, each) for each in value]
            if isinstance(value, Struct):
                return value.pointer[0]
            return value.ravel().tolist() if isinstance(value, np.ndarray) else value
        if isinstance(value, Struct):
            return value.pointer
        address = value.ctypes.data if isinstance(value, np.ndarray) else value
        return self._ffi.cast(kind, address or 0)


_FORMATS: Final = {"double": "f8", "long long": "i8"}


def records(layout: Layout, name: str, count: int) -> NDArray[np.void]:
    """Return zeros as an array of so many structs of the type `name` of the headers; pointers in it are addresses."""
    ffi = kernel(layout).ffi
    fields = ffi.typeof(name).fields
    dtype = np.dtype(
        {
            "names": [field for field, _ in fields],
            "formats": [_FORMATS.get(description.type.cname, "u8") for _, description in fields],
            "offsets": [description.offset for _, description in fields],
            "itemsize": ffi.sizeof(name),
        }
    )
    return np.zeros(count, dtype=dtype)


@cache
def address_of(step: ca.Function) -> int:
    """Return the address of `void call(double *state, const double *input, const double *parameter, double *output)`.

    It calls a function (state, input, parameter) → (state, output) and leaves the new state where the old one was.

    Raises:
        railgrip.errors.CompilerMissing: There is no C compiler.
    """
    generator = ca.CodeGenerator("step", {"with_header": False, "casadi_int": "int"})
    generator.add(step)
    sizes = {
        "NX": step.numel_out(0), "WORK": step.sz_w(), "INDEX": step.sz_iw(), "ARGUMENTS": step.sz_arg(),
        "RESULTS": step.sz_res(),
    }  # fmt: skip
    header = "".join(
        [
            *(f"#define {name} {value}\n" for name, value in sizes.items()),
            "#define CASADI_SYMBOL_EXPORT static\n",
            generator.dump(),
        ]
    )
    sources = {"step.h": header, "formula.c": (KERNEL / "formula.c").read_text(encoding="utf-8")}
    library = ctypes.CDLL(str(shared_library(sources, "formula")))
    return ctypes.cast(library.call, ctypes.c_void_p).value or 0
