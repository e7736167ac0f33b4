"""The loop's own code in C, and formulas as functions in C: compiled once on a machine."""

import ctypes
from functools import cache
from importlib.resources import files
from typing import Final

import casadi as ca

from railgrip.fmus.native.c_library import CLibrary
from railgrip.fmus.native.toolchain import shared_library
from railgrip.signals import Layout
from railgrip.units import GRAVITY
from railgrip.vehicle.slip import SMALL_SPEED

KERNEL: Final = files("railgrip.loop") / "kernel"
_HEADERS: Final = ("sensors.h", "plausible.h", "driver.h", "rail.h", "faults.h", "cycle.h")
_PHYSICS: Final = f"#define GRAVITY {GRAVITY}\n#define SMALL_SPEED {SMALL_SPEED}\n"
"""Constants in SI units; no declaration of the headers needs them."""


@cache
def kernel(layout: Layout) -> CLibrary:
    """Return the sensors, plausibility checks, driver, rail, faults and cycle in C, for vectors of this layout.

    Raises:
        railgrip.errors.CompilerMissing: There is no C compiler.
    """
    constants, formation = layout.header(), layout.formation
    names = ("export.h", *_HEADERS, *(name.replace(".h", ".c") for name in _HEADERS))
    sources = {name: (KERNEL / name).read_text(encoding="utf-8") for name in names}
    name = f"cycle_{formation.groups}_{formation.wheelsets}"
    return CLibrary(sources | {"layout.h": constants + _PHYSICS}, name, _HEADERS, constants)


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
