"""The contact of a scenario as a function of arrays, compiled from the Modelica class that the plant uses.

On a rail that slip cleans, `with_energy` gives the cleanest rail that wheelsets can leave for those behind. The ideal
bound on such a rail is optimistic: each wheelset meets its place as clean as those ahead can have made it with the slip
that leaves the highest energy there, and still uses its own best slip. No stop is shorter: with kinetic energy e over
distance s of the train, de/ds ≥ −a(s, e, past e) for any controller, where the deceleration a of the bound falls with
both speeds, because friction falls with slip speed and rises with the energy on the rail. A train that is as fast as
that of the bound was faster before, met less clean rail, and decelerates less.
"""

import ctypes
from collections.abc import Callable
from functools import cache
from importlib.resources import files

import casadi as ca
import numpy as np
import xarray

from railgrip.base.arrays import Array
from railgrip.fmus.native import Model
from railgrip.fmus.native.c_source import in_c, table
from railgrip.fmus.native.toolchain import shared_library
from railgrip.scenario.surface import Recovery
from railgrip.trace.bound import Contact, contact_at

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
    of_all = np.array([[value] for value in shape.values()])
    run, fixed = _library(model, tuple(shape)), _geometry_terms(model, parameters, tuple(shape))

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


def contact_header(model: Model, parameters: dict[str, float], shape: dict[str, float]) -> str:
    """Return C code: `contact` of (point, contact_curve, contact_fixed), and these tables; see `compiled_contact`."""
    header, *_ = _contact_in_c(model, tuple(shape))
    fixed = _geometry_terms(model, parameters, tuple(shape))
    tables = {"contact_curve": [*shape.values()], "contact_fixed": fixed.ravel().tolist()}
    return "\n".join([header, *(table("double", name, values) for name, values in tables.items())])


def _geometry_terms(model: Model, parameters: dict[str, float], shape: tuple[str, ...]) -> Array:
    _, of_geometry, geometry = _contact_in_c(model, shape)
    values = {variable.name: variable.start for variable in model.parameters} | parameters
    return np.array(of_geometry([values[name] for name in geometry]), dtype=np.float64)


@cache
def _contact_in_c(model: Model, shape: tuple[str, ...]) -> tuple[str, ca.Function, tuple[str, ...]]:
    """Return contact.h, a function that precomputes the contact's geometry terms, and the geometry parameters.

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
    return header, ca.Function("fixed", [of_wheel_and_rail], [ca.vertcat(*fixed)]), geometry


@cache
def _library(model: Model, shape: tuple[str, ...]) -> Callable[..., None]:
    header, *_ = _contact_in_c(model, shape)
    sources = {"contact.h": header, "contact.c": KERNEL.read_text(encoding="utf-8")}
    run = ctypes.CDLL(str(shared_library(sources, "contact"))).contact_at
    pointer = ctypes.c_void_p
    run.argtypes, run.restype = [ctypes.c_size_t, *[pointer] * 5, ctypes.c_size_t, pointer, pointer], None
    return run


SLIPS_OF_TWO_MAXIMA = np.geomspace(1e-4, 1.0, 65)
"""Grid for `railgrip.trace.bound.peak`: where two maxima are nearly equal, the lower one may be found.

On random rails with the shipped creep curves, the highest adhesion is missed by up to 2 %, and by 1e-5 on average."""

_TOLERANCE = 1e-3  # of the energy of a wheelset on its own metre of rail; the iteration ends above the solution
_ITERATIONS = 30
_SLIPS = np.geomspace(0.1, 1.0, 12)  # slips that clean most are large
_STRIDE = 0.02  # s between places at which the energy is computed


class CleanedContact:
    """Adhesion as a function of slip, speed, load and mu0, on a rail that slip cleans.

    It takes `curve` as the contact of the plant does, and `energy`, the slip energy that wheelsets ahead have left on
    the rail, per wheel [J/m]. The wheelset adds its own, with steady slip; of two steady states it has that of the
    higher friction. The law is that of `railgrip.scenario.surface.SlipEnergy`.
    """

    def __init__(self, contact: Contact, clean: Recovery, curve: Array) -> None:
        """Take the contact of the plant, the law of cleaning, and the creep curve where no other is given."""
        self._contact, self._clean, self._curve = contact, clean, curve

    def __call__(self, slip: Array, speed: Array, load: Array, mu0: Array, **place: Array) -> Array:
        """Return the adhesion, element by element."""
        friction = self.friction(slip, speed, load, mu0, **place)
        return self._plant(slip, speed, load, friction, place)

    def friction(self, slip: Array, speed: Array, load: Array, mu0: Array, **place: Array) -> Array:
        """Return the friction that a wheelset meets, as the input mu0 of the plant's contact."""
        share, decay = place.get("curve", self._curve)[2:]
        clean, slip_speed, ahead = self._clean, slip * speed, place.get("energy", 0.0)
        factor = (1.0 - share) * np.exp(-decay * slip_speed) + share
        of_clean = clean.mu0 * ((1.0 - clean.A) * np.exp(-clean.B * slip_speed) + clean.A) / factor
        rise, own = np.maximum(of_clean - mu0, 0.0), 0.5 * load * slip
        friction = np.minimum(mu0 + rise, 1.0)
        for _ in range(_ITERATIONS):
            before, own = own, 0.5 * load * slip * self._plant(slip, speed, load, friction, place)
            friction = np.minimum(mu0 - np.expm1(-clean.rate * (ahead + own)) * rise, 1.0)
            if np.all(before - own <= _TOLERANCE * before):
                break
        return friction

    def _plant(self, slip: Array, speed: Array, load: Array, friction: Array, place: dict[str, Array]) -> Array:
        return self._contact(slip, speed, load, friction, **{k: v for k, v in place.items() if k == "curve"})


def with_energy(trace: xarray.Dataset, contact: CleanedContact) -> xarray.Dataset:
    """Return a trace with `energy_ahead`: the highest energy that the wheelsets ahead can have left, (time, wheelset).

    It is per wheel [J/m]. Wheelsets start on rail that those ahead have not passed.

    Args:
        trace: Speed, distance, loads, friction of the untreated rail, and the positions of the wheelsets.
        contact: Contact on the rail that slip cleans.
    """
    time, behind = trace["time"].values, trace["wheelset_position"].values
    every = max(1, round(_STRIDE / (time[1] - time[0]))) if len(time) > 1 else 1
    part = trace.isel(time=slice(None, None, every))
    distance, speed, load, mu0 = (part[name].values for name in ("distance", "speed", "wheelset_load", "mu0"))
    energy, left = np.zeros((len(time), len(behind))), np.zeros(load.shape)
    for w in range(len(behind)):
        for ahead in range(w):
            passed = trace["distance"].values - (behind[w] - behind[ahead])
            energy[:, w] += np.interp(passed, distance, left[:, ahead], left=0.0)
        here = contact_at(contact, part.assign(energy_ahead=(("time", "wheelset"), energy[::every])), members=[w])
        for slip in _SLIPS.tolist():
            adhesion = here(np.full((len(speed), 1), slip), speed[:, None], load[:, [w]], mu0[:, [w]])[:, 0]
            left[:, w] = np.maximum(left[:, w], 0.5 * adhesion * load[:, w] * slip)
    return trace.assign(energy_ahead=(("time", "wheelset"), energy))
