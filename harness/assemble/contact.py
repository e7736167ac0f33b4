"""The contact of a scenario as a function of arrays, compiled from the Modelica class that the plant uses."""

import ctypes
from collections.abc import Callable
from functools import cache
from importlib.resources import files

import casadi as ca
import numpy as np

from railgrip.fmus.native import Model
from railgrip.fmus.native.toolchain import shared_library
from railgrip.trace.contact import Array, Contact

KERNEL = files("railgrip.assemble") / "kernel" / "contact.c"

_ORDER = ("slip", "speed", "load", "mu0")


def compiled_contact(model: Model, parameters: dict[str, float], shape: dict[str, float]) -> Contact:
    """Return adhesion as a function of slip, speed [m/s], load [N] and mu0, element by element.

    Its argument `curve`, if given, has Polach's four numbers of each element in the order of `shape`.

    Args:
        model: `RailBraking.FMUs.ContactPoint`: the physics is written once.
        parameters: Of wheel and rail, where they are not those of the class.
        shape: Of the creep curve, where `curve` is not given.
    """
    names = [variable.name for variable in model.parameters]
    values = {variable.name: variable.start for variable in model.parameters} | parameters | shape
    own = np.array([values[name] for name in names])
    places = np.array([names.index(name) for name in shape], dtype=np.longlong)
    run = _library(model)

    def adhesion(slip: Array, speed: Array, load: Array, mu0: Array, curve: Array | None = None) -> Array:
        points = [np.ascontiguousarray(each, dtype=np.float64) for each in np.broadcast_arrays(slip, speed, load, mu0)]
        result, parameter = np.empty(points[0].shape), own.copy()
        each_curve = None if curve is None else np.ascontiguousarray(curve, dtype=np.float64)
        run(
            result.size, *(each.ctypes.data for each in points), parameter.ctypes.data,
            None if each_curve is None else each_curve.ctypes.data, places.ctypes.data, result.ctypes.data,
        )  # fmt: skip
        return result

    return adhesion


@cache
def _library(model: Model) -> Callable[..., None]:
    point, parameters = ca.SX.sym("point", len(model.inputs)), ca.SX.sym("parameters", len(model.parameters))
    function = ca.Function("contact", [point, parameters], [model.output(0, ca.SX(0, 1), point, parameters)])
    generator = ca.CodeGenerator("contact", {"with_header": False})
    generator.add(function)
    sizes = {"ARG": function.sz_arg(), "RES": function.sz_res(), "IW": function.sz_iw(), "W": function.sz_w()}
    inputs = [variable.name for variable in model.inputs]
    places = {name.upper(): inputs.index(name) for name in _ORDER}
    header = "".join(
        [
            *(f"#define {name} {place}\n" for name, place in places.items()),
            *(f"#define contact_SZ_{name} {size}\n" for name, size in sizes.items()),
            generator.dump(),
        ]
    )
    sources = {"contact.h": header, "contact.c": KERNEL.read_text(encoding="utf-8")}
    run = ctypes.CDLL(str(shared_library(sources, "contact"))).contact_at
    run.argtypes, run.restype = [ctypes.c_size_t] + [ctypes.c_void_p] * 8, None
    return run
