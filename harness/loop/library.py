"""The loop's own code in C, and formulas as functions in C: compiled once on a machine."""

import ctypes
from functools import cache
from importlib.resources import files
from typing import Final

import casadi as ca

from railgrip.fmus.native.toolchain import shared_library
from railgrip.signals import Layout

KERNEL: Final = files("railgrip.loop") / "kernel"
_PARTS: Final = tuple(
    f"{part}.{kind}" for part in ("sensors", "plausible", "driver", "rail", "faults") for kind in "hc"
)


@cache
def kernel(layout: Layout) -> ctypes.CDLL:
    """Return the sensors, checks of a plant, driver, rail, faults and the cycle in C, for vectors of this layout.

    Raises:
        railgrip.errors.CompilerMissing: There is no C compiler.
    """
    sources = {part: (KERNEL / part).read_text(encoding="utf-8") for part in (*_PARTS, "cycle.c")}
    formation = layout.formation
    name = f"cycle_{formation.groups}_{formation.wheelsets}"
    library = ctypes.CDLL(str(shared_library(sources | {"layout.h": layout.header()}, name)))
    library.read_encoder.argtypes = [ctypes.c_void_p, ctypes.c_longlong, ctypes.c_double]
    library.read_encoder.restype = ctypes.c_double
    library.read_service.argtypes = [ctypes.c_void_p, ctypes.c_longlong, ctypes.c_void_p, ctypes.c_void_p]
    library.read_service.restype = None
    library.plausible.argtypes = [ctypes.c_void_p, ctypes.c_longlong, ctypes.c_void_p, ctypes.c_void_p]
    library.plausible.restype = ctypes.c_int
    library.drive.argtypes = [ctypes.c_void_p, ctypes.c_longlong, ctypes.c_void_p]
    library.drive.restype = None
    library.roll.argtypes, library.roll.restype = [ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p], None
    library.show_faults.argtypes = [ctypes.c_void_p, ctypes.c_longlong, ctypes.c_void_p]
    library.pass_faults.argtypes = [ctypes.c_void_p, ctypes.c_longlong, *[ctypes.c_void_p] * 3]
    library.show_faults.restype = library.pass_faults.restype = None
    library.cycle.argtypes, library.cycle.restype = [ctypes.c_void_p, ctypes.c_longlong], ctypes.c_int
    return library


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
