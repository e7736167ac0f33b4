"""The contact of a scenario as a function of arrays, compiled from the Modelica class that the plant uses."""

import ctypes
from collections.abc import Callable
from functools import cache
from importlib.resources import files

import casadi as ca
import numpy as np

from railgrip.fmus.native import Model
from railgrip.fmus.native.c_source import in_c
from railgrip.fmus.native.toolchain import shared_library
from railgrip.trace.contact import Array, Contact

KERNEL = files("railgrip.simulate") / "kernel" / "contact.c"

_ORDER = ("slip", "speed", "load", "mu0")


def compiled_contact(model: Model, parameters: dict[str, float], shape: dict[str, float]) -> Contact:
    """Return adhesion as a function of slip, speed [m/s], load [N] and mu0, element by element.

    The optional argument `curve` gives Polach's four numbers of each element in the order of `shape`.

    Args:
        model: `RailBraking.FMUs.ContactPoint`, so that the plant and this function use the same equations.
        parameters: Wheel and rail parameters that differ from those of the class.
        shape: Parameters of the creep curve, used where `curve` is not given.
    """
    values = {variable.name: variable.start for variable in model.parameters} | parameters | shape
    of_all = np.array([[value] for value in shape.values()])
    run, of_geometry, geometry = _library(model, tuple(shape))
    fixed = np.array(of_geometry([values[name] for name in geometry]), dtype=np.float64)

    def adhesion(slip: Array, speed: Array, load: Array, mu0: Array, curve: Array | None = None) -> Array:
        points = [np.ascontiguousarray(each, dtype=np.float64) for each in np.broadcast_arrays(slip, speed, load, mu0)]
        result = np.empty(points[0].shape)
        curves = np.ascontiguousarray(of_all if curve is None else curve, dtype=np.float64)
        run(
            result.size, *(each.ctypes.data for each in points), curves.ctypes.data, curves[0].size, fixed.ctypes.data,
            result.ctypes.data,
        )  # fmt: skip
        return result

    return adhesion


@cache
def _library(model: Model, shape: tuple[str, ...]) -> tuple[Callable[..., None], ca.Function, tuple[str, ...]]:
    """Return the contact in C, a function that precomputes its geometry terms, and the geometry parameters.

    The axes of the contact patch are three powers of constants; they are computed once and passed to the C function.
    """
    symbols = {variable.name: ca.SX.sym(variable.name) for variable in model.parameters}
    geometry = tuple(name for name in symbols if name not in shape)
    point = ca.SX.sym("point", len(model.inputs))
    expression = model.output(0, ca.SX(0, 1), point, ca.vertcat(*symbols.values()))
    of_wheel_and_rail = ca.vertcat(*(symbols[name] for name in geometry))
    adhesion, extracted, fixed = ca.extract_parametric(expression, of_wheel_and_rail, {"extract_trivial": True})
    curve = ca.vertcat(*(symbols[name] for name in shape))
    function = ca.Function("contact", [point, curve, ca.vertcat(*extracted)], [adhesion])
    sizes, text = in_c([function])
    inputs = [variable.name for variable in model.inputs]
    places = {name.upper(): inputs.index(name) for name in _ORDER}
    macros = {**places, **sizes, "CURVE": len(shape)}
    header = "".join(f"#define {name} {value}\n" for name, value in macros.items()) + text
    sources = {"contact.h": header, "contact.c": KERNEL.read_text(encoding="utf-8")}
    run = ctypes.CDLL(str(shared_library(sources, "contact"))).contact_at
    pointer = ctypes.c_void_p
    run.argtypes, run.restype = [ctypes.c_size_t, *[pointer] * 5, ctypes.c_size_t, pointer, pointer], None
    return run, ca.Function("fixed", [of_wheel_and_rail], [ca.vertcat(*fixed)]), geometry
