"""A CasADi formula as a function in C: compiled once on a machine."""

import ctypes
from functools import cache

import casadi as ca

from railgrip.fmus.native.toolchain import shared_library
from railgrip.loop.library import KERNEL


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
