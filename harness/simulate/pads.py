"""Pad friction along the stop of the ideal bound: the highest that a controller can have there.

Pads have more friction after low force, at low disc speed and on hot discs, and settle over friction work
(`RailBraking.Friction.PadFriction`). The friction of a group rises as fast, or falls as slowly, as one of these choices
makes it:

- Where the rail limits the group, or dynamic brakes may relieve its pads: any force up to the full one, and any disc
  speed up to that of rolling.
- Where the brakes limit it: full force, and any disc speed that its wheelsets can have. Without a slide that is the
  speed of rolling less the slip at which the contact carries the brake; after a slide, less the slip behind the peak at
  which it does; and any, until the wheelsets have regained the speed of rolling. On a rail that slip cleans, any: the
  bound has the cleanest rail, and a wheelset may lock on a less clean one.

A controller may also press with less than full force where the brakes limit, to have more friction later, but it does
not gain by that: all effects together change friction by about a quarter, so that lost impulse returns in part only.
"""

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import casadi as ca
import numpy as np
import xarray

from railgrip.base.arrays import Array
from railgrip.fmus.native import Model
from railgrip.rolling_stock.schema import load_train
from railgrip.scenario.vehicle_table import TrainFile
from railgrip.simulate.named_models import compile_class
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.trace.bound import contact_at
from railgrip.trace.contact import Contact
from railgrip.vehicle.brake import Brake

_CALL = 500  # steps computed in one call
_STRIDE = 0.01  # s; pads settle over tenths of a second at full force
_FORCES = np.linspace(0.25, 1.0, 3)  # of the full force; below, friction settles too slowly to rise faster
_SHARES = np.linspace(0.0, 1.0, 4)  # of the range of disc speeds

_RISE = np.array([0.0625, 0.125, 0.25, 0.5, 1.0])  # of the slip of the peak

_NO_LIMIT = np.array([[0.0], [1e12], [0.0], *([1e12 * share] for share in _RISE)])
"""Rail without slides, as `PadLimits._rail` of a group: slip, and torques [N.m]."""

_Path = tuple[Array, ca.Function]

_OF_GROUP = {
    "pad.mu_nominal": "mu_b_nominal", "pad.mu_start": "mu_b_start", "disc.T_start": "T_disc_start",
    "n_units": "n_units", "r_friction": "r_friction",
}  # fmt: skip
_OF_DISC = {"disc.m": "m_disc", "disc.m_surface": "m_disc_surface", "disc.c_p": "c_disc", "disc.G": "G_disc"}
"""Parameter of `RailBraking.Components.GroupBrake` → that of the plant, where the names differ."""

_OF_LAW = {
    "pad.F_upper": "force_upper", "pad.F_lower": "force_lower", "pad.v_upper": "speed_upper",
    "pad.v_lower": "speed_lower",
}  # fmt: skip
"""Parameter of `RailBraking.Components.TreadBrake` → entry of the law of blocks."""

_OF_FILE = {
    "pad.pad_speed_nominal": "speed_nominal",
    "pad.pad_force_nominal": "force_nominal",
    "pad.E_settle": "settle_energy",
    **_OF_LAW,
}
"""Parameter of `RailBraking.Components.GroupBrake` → entry of [pads] in a train file, where the names differ."""


class PadTable:
    """Pad friction by speed, as in a stop without slides; for plants whose pads are not known."""

    def __init__(self, speeds: Array, friction: Array) -> None:
        """Take rising speeds, shape (k,) [m/s], and the friction there, shape (k, groups)."""
        self._speeds, self._friction = speeds, friction

    def friction(self, speed: Array, bound: xarray.Dataset | None) -> Array:  # pyright: ignore[reportUnusedParameter]
        """Return the friction of each group, shape (n, groups), at the speeds of a stop, shape (n,) [m/s]."""
        return np.stack([np.interp(speed, self._speeds, each) for each in self._friction.T], axis=1)


class PadLimits:
    """Highest friction of the pads of each group, from the plant's parameters of pads and discs."""

    def __init__(self, vehicle: VehicleData, contact: Contact) -> None:
        """Take the parameters of a vehicle's plant, and the contact on the rail of the bound."""
        period = vehicle.scenario.periods.communication
        self._vehicle, self._contact, self._stride = vehicle, contact, max(1, round(_STRIDE / period))
        limits = vehicle.dynamic_limits
        is_across = any(limit.across for limit in limits.values())
        can_lock = vehicle.scenario.adhesion.cleaning is not None
        self._paths = [
            None
            if brake is None
            else _path(
                _model(vehicle, group),
                _parameters(vehicle, group),
                brake,
                self._stride * period,
                can_lock=can_lock,
                is_relieved=is_across or group in limits,
            )
            for group, brake in enumerate(vehicle.true.brakes)
        ]

    def friction(self, speed: Array, bound: xarray.Dataset | None) -> Array:
        """Return the friction, shape (n, groups); 0 for a group without brakes.

        Args:
            speed: Speed of the train, shape (n,) [m/s]; friction is constant after standstill.
            bound: A trace as `with_bound` returns it, of up to n samples; without it, the brakes limit all groups.
        """
        friction = np.zeros((len(speed), len(self._paths)))
        sampled = speed[: np.count_nonzero(speed) + 1 : self._stride]
        rail = np.tile(_NO_LIMIT, (len(self._paths), 1, 1)) if bound is None else self._rail(bound)
        at = np.arange(_CALL * -(-len(sampled) // _CALL))
        places, samples = np.minimum(at, rail.shape[-1] - 1), np.minimum(at, len(sampled) - 1)
        for group, path in enumerate(self._paths):
            if path is not None:
                state, steps = path
                found = [state[:1]]
                for inputs in np.split(np.vstack([sampled[samples], rail[group][:, places]]), len(at) // _CALL, axis=1):
                    states = np.asarray(steps(state, inputs))
                    state = states[:, -1]
                    found.append(states[0])
                path_of_all = np.concatenate(found)
                times = self._stride * np.arange(len(path_of_all))
                friction[:, group] = np.interp(np.arange(len(speed)), times, path_of_all)
        return friction

    def _rail(self, bound: xarray.Dataset) -> Array:
        """Return the slip of the highest adhesion and brake torques [N.m], shape (groups, 3 + len(_RISE), steps).

        The torques hold α_max, the adhesion of locked wheels, and that at shares of the slip of the highest.
        """
        vehicle = self._vehicle
        trace = bound.isel(time=slice(None, None, self._stride))
        load, mu0, peak_slip = (trace[name].values for name in ("wheelset_load", "mu0", "peak_slip"))
        speed = np.broadcast_to(trace["speed"].values[:, None], load.shape)
        contact, group_load = contact_at(self._contact, trace), vehicle.formation.sum_by_group(load)
        slips = [np.ones(load.shape), *(share * peak_slip[:, vehicle.formation.group_of_wheelset] for share in _RISE)]
        forces = [vehicle.formation.sum_by_group(contact(slip, speed, load, mu0) * load) for slip in slips]
        radius, inertia = (
            np.array([1.0 if b is None else getattr(b, name) for b in vehicle.true.brakes])
            for name in ("wheel_radius", "inertia")
        )
        deceleration = -trace["acceleration"].values[:, None]
        beyond = inertia * deceleration / radius - vehicle.resistance_lever * group_load
        torques = [force * radius + beyond for force in (vehicle.scenario.limits.alpha_max * group_load, *forces)]
        return np.stack([peak_slip, *torques]).transpose(2, 0, 1)


def pads_of(vehicle: VehicleData, contact: Contact, speeds: Array, friction: Array) -> PadLimits | PadTable:
    """Return the limits of a plant of this library, whose parameters describe pads and discs, else the table.

    Args:
        vehicle: Vehicle of the plant.
        contact: Contact on the rail of the bound.
        speeds: Rising speeds of the table, shape (k,) [m/s].
        friction: Pad friction there, shape (k, groups).
    """
    is_file = isinstance(vehicle.scenario.vehicle.source, TrainFile)
    is_known = is_file or {"mu_b_start[1]", "speed_effect", "m_disc"} <= vehicle.true.parameters.keys()
    return PadLimits(vehicle, contact) if is_known else PadTable(speeds, friction)


def _model(vehicle: VehicleData, group: int) -> Model:
    """Return the class of the brake units of a group, with pads or with blocks."""
    source = vehicle.scenario.vehicle.source
    has_blocks = isinstance(source, TrainFile) and load_train(source.file.path).bogie_of(group).brake.blocks
    return compile_class(f"RailBraking.Components.{'TreadBrake' if has_blocks else 'GroupBrake'}")


def _parameters(vehicle: VehicleData, group: int) -> list[float]:
    """Return the parameters of the class for a group."""
    plant, source = vehicle.true.parameters, vehicle.scenario.vehicle.source
    pads: Mapping[str, float] = {}
    if isinstance(source, TrainFile):
        bogie = load_train(source.file.path).bogie_of(group)
        pads = bogie.pads.model_dump() | {name: getattr(bogie.law, name) for name in _OF_LAW.values()}
    values: list[float] = []
    for parameter in _model(vehicle, group).parameters:
        name, last = parameter.name, parameter.name.rpartition(".")[2]
        of_plant = f"{_OF_GROUP[name]}[{group + 1}]" if name in _OF_GROUP else _OF_DISC.get(name, last)
        values.append(pads.get(str(_OF_FILE.get(name, last)), plant.get(of_plant, parameter.start)))
    return values


def _path(
    model: Model, parameters: list[float], brake: Brake, step: float, *, can_lock: bool, is_relieved: bool
) -> _Path:
    """Return the states at the start and the function from states and inputs to states after a step.

    The states are those of the class, friction first, and two momenta [N.s] that a slide can have taken from the
    wheelsets: one returns at the highest adhesion of the rail, the other at that of locked wheels. The inputs are speed
    and rail, as `PadLimits._rail` returns it.
    """
    state, inputs = ca.SX.sym("state", len(model.states) + 2), ca.SX.sym("inputs", 4 + len(_RISE))
    speed, peak_slip, allowed, locked, *rising = ca.vertsplit(inputs)
    peak = ca.fmin(rising[-1], allowed)
    full, rolling = brake.pad_force(brake.pressure_max), speed / brake.wheel_radius
    soonest, latest = state[-2], state[-1]

    def at(force: float | ca.SX, turning: ca.SX) -> list[Any]:
        return [0, state[:-2], ca.vertcat(force, turning, speed), parameters]

    def highest(forces: Array, slowest: ca.SX | float) -> ca.SX:
        """Return the highest friction after the step, for disc speeds up to that of rolling."""
        found = ca.SX(-ca.inf)
        for force in forces.tolist():
            for share in _SHARES.tolist():
                slope = model.derivative(*at(force * full, (slowest + share * (1 - slowest)) * rolling))[0]
                rate = -ca.jacobian(slope, state[0])
                found = ca.fmax(found, state[0] + slope * (1 - ca.exp(-rate * step)) / rate)
        return found

    torque = model.output(*at(full, rolling))[0]
    used = ca.fmax(ca.fmin(peak, torque), 0)
    # Chords of the curve, which is concave up to its peak and convex behind, give the slips that full force holds.
    creeping: Any = 0.0
    for (slip, low), (next_slip, high) in pairwise([(0.0, 0.0), *zip(_RISE.tolist(), rising, strict=True)]):
        creeping += (next_slip - slip) * peak_slip * ca.fmin(ca.fmax((torque - low) / (high - low), 0), 1)
    sliding = ca.fmin(peak_slip + (1 - peak_slip) * (peak - torque) / (peak - locked), 1)
    is_limited = peak < torque
    slip = ca.if_else(soonest > 0, 1, ca.if_else(latest > 0, sliding, creeping))
    slides = ca.logic_or(is_limited, latest > 0)
    momenta = (
        soonest + (torque - peak) / brake.wheel_radius * step,
        latest + slides * (torque - locked) / brake.wheel_radius * step,
    )
    largest = speed * brake.inertia / brake.wheel_radius**2
    after = ca.vertcat(
        highest(_FORCES, 0.0)
        if is_relieved
        else ca.if_else(is_limited, highest(_FORCES, 0.0), highest(np.ones(1), 0.0 if can_lock else 1 - slip)),
        state[1:-2] + step * model.derivative(*at(full * used / torque, rolling))[1:],
        *(ca.fmin(ca.fmax(momentum, 0), largest) for momentum in momenta),
    )
    start = np.append(np.asarray(model.initial(parameters)).ravel(), [0.0, 0.0])
    return start, ca.Function("pads", [state, inputs], [after]).mapaccum(_CALL)
