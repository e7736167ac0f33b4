"""The ideal bound: the highest adhesion that control can use at a sample of a stop.

For each group it is the minimum of three limits: peak adhesion, which the rail gives at the best slip; brake limit,
which full brake pressure draws, or the pressure that the driver demands, with other brakes on the wheelsets; and α_max,
which the operator allows. The brake limit includes bearing and rolling resistance, which act through the contact as a
brake does. It holds for a constant slip: a wheelset that regains speed draws more for a moment, which
`regained_adhesion` gives.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray

from railgrip.base.arrays import Array
from railgrip.trace.recorder import formation_in
from railgrip.vehicle.brake import Brake
from railgrip.vehicle.signals import CURVE

Contact = Callable[..., Array]
"""contact(slip, speed [m/s], wheelset load [N], mu0) → adhesion; arrays of one shape, element by element.

One that can do so takes `curve` with Polach's k_A, k_S, A and B [s/m] of each element, shape (4, …)."""

SLIPS = np.geomspace(1e-4, 1.0, 33)  # the narrowest published curve peaks near 3e-3; 1 is a locked wheel
_GOLDEN = (np.sqrt(5) - 1) / 2
_REFINEMENTS = 9  # shrinks the bracket of ±1 grid step to 0.8 % of the slip; a parabola does the rest


def peak(contact: Contact, speed: Array, load: Array, mu0: Array, slips: Array = SLIPS) -> tuple[Array, Array]:
    """Return the best common slip of wheelsets that turn as one, and the adhesion of each at it.

    The best of a logarithmic grid of slips, refined by golden section on its logarithm and by a parabola through the
    last points; at each sample on its own. Below the locked wheel a curve is assumed to have one maximum within four
    grid steps (a factor of 3.2 in slip); one that rises again towards the lock may have its greatest value there.

    Args:
        contact: The creep curve.
        speed: Of the train, shape (n,) [m/s].
        load: Of each wheelset, shape (n, k) [N].
        mu0: Maximum friction at each wheelset, shape (n, k).
        slips: The grid, an odd number of slips, rising.

    Returns:
        Slip, shape (n,), and adhesion, shape (n, k).
    """

    def adhesion(log_slip: Array) -> Array:
        slip = np.broadcast_to(np.exp(log_slip)[:, None], load.shape)
        return contact(slip, np.broadcast_to(speed[:, None], load.shape), load, mu0)

    def force(log_slip: Array) -> Array:
        return np.sum(adhesion(log_slip) * load, axis=1)

    grid, every = np.log(slips), np.arange(len(speed))
    last = len(grid) - 1
    # Every other slip first, then the neighbours of the best.
    coarse = np.stack([force(np.full(speed.shape, point)) for point in grid[::2]])
    best = 2 * np.argmax(coarse[:-1], axis=0)
    around = [np.maximum(best - 1, 0), best, np.minimum(best + 1, last)]
    candidates = np.stack([force(grid[around[0]]), coarse[best // 2, every], force(grid[around[2]])])
    nearest = np.argmax(candidates, axis=0)
    best, highest = np.stack(around)[nearest, every], candidates[nearest, every]
    low, high = grid[np.maximum(best - 1, 0)], grid[np.minimum(best + 1, last)]
    left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    force_left, force_right = force(left), force(right)
    for _ in range(_REFINEMENTS):
        rises = force_left < force_right
        low, high = np.where(rises, left, low), np.where(rises, high, right)
        fresh = np.where(rises, low + _GOLDEN * (high - low), high - _GOLDEN * (high - low))
        force_fresh = force(fresh)
        left, right = np.where(rises, right, fresh), np.where(rises, fresh, left)
        force_left, force_right = (
            np.where(rises, force_right, force_fresh),
            np.where(rises, force_fresh, force_left),
        )
    middle = (low + high) / 2
    vertex = _vertex((left, middle, right), (force_left, force(middle), force_right))
    fine = np.clip(vertex, low, high)
    # A maximum at the edge of the grid is not inside the bracket: never return less than the grid had.
    force_there = force(fine)
    place = np.where(force_there >= highest, fine, grid[best])
    place = np.where(coarse[-1] > np.maximum(force_there, highest), grid[last], place)
    return np.exp(place), adhesion(place)


def _vertex(points: tuple[Array, Array, Array], values: tuple[Array, Array, Array]) -> Array:
    """Return where the parabola through three points with the middle one halfway has its vertex; the middle if flat."""
    left, middle, right = points
    bend = values[0] - 2.0 * values[1] + values[2]
    shift = np.divide(values[0] - values[2], 2.0 * bend, out=np.zeros_like(bend), where=bend < 0.0)
    return middle + 0.5 * (right - left) * shift


_STRIDE = 0.01  # s between creep curves; rail and loads (pitch near 7 Hz) are straight lines over so short a time


@dataclass(frozen=True, slots=True, kw_only=True)
class DynamicLimit:
    """What electrodynamic and eddy-current brakes on the axles of a group change of its brake limit.

    Attributes:
        force: Available force at the rim [N] as a function of speeds [m/s].
        nominal_friction: Pad friction with which dynamic brakes relieve friction brakes; 0 where they add to them.
        across: Whether they also brake for other groups.
    """

    force: Callable[[Array], Array]
    nominal_friction: float
    across: bool

    def torque(self, speed: Array, friction: Array, nominal: Array, wheel_radius: float) -> Array:
        """Return the highest torque of all brakes of the group [N.m], shape (n,).

        Args:
            speed: Of the train, shape (n,) [m/s].
            friction: Torque of the friction brakes alone, shape (n,) [N.m].
            nominal: The same with nominal pad friction.
            wheel_radius: Rolling radius [m].
        """
        available = self.force(speed) * wheel_radius
        if not self.nominal_friction:
            return friction + available
        # Where pads have less than nominal friction the train brakes best with as much dynamic force as possible.
        replaced = np.minimum(available / np.maximum(nominal, 1e-3), 1.0)
        mixed = friction + replaced * np.maximum(nominal - friction, 0.0)
        return np.maximum(mixed, available) if self.across else mixed


def brake_limit(
    brake: Brake,
    pad_friction: Array,
    load: Array,
    deceleration: Array,
    pressure: Array | None = None,
    resistance_lever: float = 0.0,
    other_torque: Array | float = 0.0,
    speed: Array | None = None,
    dynamic: DynamicLimit | None = None,
) -> Array:
    """Return the adhesion at which full pressure, or another, holds the slip of a group, shape (n,).

    Args:
        brake: Of the group.
        pad_friction: Of the group, shape (n,).
        load: Of the group, shape (n,) [N].
        deceleration: Of the train, shape (n,) [m/s2]; some torque goes into slowing the wheelsets.
        pressure: Highest pressure of the group, shape (n,) [Pa]; None for full.
        resistance_lever: Torque of bearings and rolling over the load [m].
        other_torque: Torque of brakes that the train file does not have, see `torque_beyond_pads`, shape (n,) [N.m].
        speed: Of the train, shape (n,) [m/s]; needed with `dynamic`.
        dynamic: Electrodynamic and eddy-current brakes of the group.
    """
    most = brake.pressure_max if pressure is None else np.minimum(pressure, brake.pressure_max)
    torque = brake.units * pad_friction * brake.pad_force(most) * brake.friction_radius
    if dynamic is not None and speed is not None:
        nominal = dynamic.nominal_friction * brake.units * brake.pad_force(most) * brake.friction_radius
        torque = dynamic.torque(speed, torque, np.broadcast_to(nominal, torque.shape), brake.wheel_radius)
    rotation = brake.inertia * deceleration / brake.wheel_radius
    return np.maximum(torque + other_torque + resistance_lever * load - rotation, 0) / (brake.wheel_radius * load)


def torque_beyond_pads(trace: xarray.Dataset, brakes: Sequence[Brake | None]) -> Array:
    """Return the torque of other brakes on the wheelsets of each group, shape (n, groups) [N.m].

    Electrodynamic and rotating eddy-current brakes use adhesion as friction brakes do. Theirs is the torque by which
    `brake_torque` exceeds that of the pads. It is 0 where the plant does not output both, where the friction brake is
    isolated, and for standing wheelsets, which a reaction holds. Brakes on the rail itself need no adhesion and are not
    included.
    """
    torque = np.zeros(trace["brake_torque"].shape)
    for group, brake in enumerate(brakes):
        if brake is not None:
            friction, force = (trace[name].values[:, group] for name in ("pad_friction", "pad_force"))
            pads = brake.units * friction * force * brake.friction_radius
            beyond = np.nan_to_num(np.maximum(trace["brake_torque"].values[:, group] - pads, 0.0))
            # The speed is unknown (NaN) in the stop of the ideal bound, whose wheelsets roll.
            torque[:, group] = np.where(trace["wheelset_speed"].values[:, group] <= 0.0, 0.0, beyond)
    return torque


def regained_adhesion(
    *, time: Array, speed: Array, usable: Array, limit: Array, load: Array, rotating_mass: Array
) -> Array:
    """Return the adhesion beyond the brake limit while groups regain speed after a slide, shape (n, groups).

    Where the rail allows less than the brakes draw, their surplus slows the wheelsets; where it allows more, the
    contact accelerates them again, beyond the brake limit. The deficit of momentum, between 0 and that of locked
    wheels, is integrated over time for each group. A slide that deep would use less than the peak adhesion: it is an
    upper limit.

    Args:
        time: Shape (n,) [s].
        speed: Of the train, shape (n,) [m/s].
        usable: Adhesion that rail and operator allow, shape (n, groups).
        limit: Adhesion that the brakes draw at constant slip, shape (n, groups).
        load: Of each group, shape (n, groups) [N].
        rotating_mass: Inertia of each group over the square of the wheel radius, shape (groups,) [kg].
    """
    stride = max(1, round(_STRIDE / (time[1] - time[0]))) if len(time) > 1 else 1
    steps = np.diff(time[::stride], append=time[-1])
    surplus = ((limit - usable) * load)[::stride] * steps[:, None]
    largest = speed[::stride, None] * rotating_mass
    regained, deficit = np.zeros(surplus.shape), np.zeros(len(rotating_mass))
    for i in range(len(surplus)):
        regained[i] = np.clip(-surplus[i], 0.0, deficit)
        deficit = np.clip(deficit + surplus[i], 0.0, largest[i])
    force = np.divide(regained, steps[:, None], out=np.zeros_like(regained), where=steps[:, None] > 0.0)
    return np.repeat(force, stride, axis=0)[: len(time)] / load


def contact_at(
    contact: Contact, trace: xarray.Dataset, samples: Any = slice(None), members: Any = slice(None)
) -> Contact:
    """Return the contact at wheelsets and samples of a trace, with their creep curves and energy on the rail, if given.

    Args:
        contact: Contact that takes `curve`, if the trace has creep curves, and `energy`, if it has `energy_ahead`.
        trace: Trace of a stop.
        samples: Index of samples.
        members: Index of wheelsets.
    """
    place: dict[str, Array] = {}
    if CURVE[0].name in trace:
        place["curve"] = np.stack([trace[signal.name].values[samples][:, members] for signal in CURVE])
    if "energy_ahead" in trace:
        place["energy"] = trace["energy_ahead"].values[samples][:, members]
    return partial(contact, **place) if place else contact


def with_bound(
    trace: xarray.Dataset,
    contact: Contact,
    brakes: Sequence[Brake | None],
    alpha_max: float,
    resistance_lever: float = 0.0,
    search: Callable[[Contact, Array, Array, Array], tuple[Array, Array]] = peak,
    dynamics: Mapping[int, DynamicLimit] = MappingProxyType({}),
    stride: float = _STRIDE,
) -> xarray.Dataset:
    """Return the trace with the variables that a comparison with the ideal needs; the brake of a group may be isolated.

    `search` finds the peak, as `railgrip.trace.bound.peak` does. `dynamics` has the dynamic brakes of groups. The peak
    is found every `stride` [s], with 0 at every sample, and is a straight line in between.

    `peak_slip`, `peak_adhesion` (time, group): of the creep curve. `brake_limit` (time, group).
    `ideal_adhesion` (time, group): the bound. `ideal_share` (time, wheelset): what each wheelset contributes
    to the bound of its group, in the proportion of their adhesion at the group's best slip.
    """
    time, speed = trace["time"].values, trace["speed"].values
    load, mu0 = trace["wheelset_load"].values, trace["mu0"].values
    formation = formation_in(trace)
    groups = formation.group_of_wheelset
    period = time[1] - time[0] if len(time) > 1 else _STRIDE
    # The last sample is always among them, so that nothing is extrapolated.
    instants = np.unique(np.append(np.arange(0, len(time), max(1, round(stride / period))), len(time) - 1))

    peak_slip, peak_each = np.empty((len(time), formation.groups)), np.empty(load.shape)
    for group, members in enumerate(formation.members()):
        here = contact_at(contact, trace, instants, members)
        slip, each = search(here, speed[instants], load[instants, members], mu0[instants, members])
        peak_slip[:, group] = np.interp(time, time[instants], slip)
        for number, member in enumerate(range(members.start, members.stop)):
            peak_each[:, member] = np.interp(time, time[instants], each[:, number])

    group_load = formation.sum_by_group(load)
    peak_adhesion = formation.sum_by_group(peak_each * load) / group_load
    demanded = None
    if "driver_demand" in trace:
        # A row holds the demand up to its instant; the demand from then on is in the next row.
        demanded = trace["driver_demand"].values[np.minimum(np.arange(len(time)) + 1, len(time) - 1)]
    force = "full" if demanded is None else "the demanded"
    pad_friction, deceleration = trace["pad_friction"].values, -trace["acceleration"].values
    limit, other = np.zeros(group_load.shape), torque_beyond_pads(trace, brakes)
    for group, brake in enumerate(brakes):
        if brake is not None:
            pressure = None if demanded is None else demanded[:, group]
            limit[:, group] = brake_limit(
                brake,
                pad_friction[:, group],
                group_load[:, group],
                deceleration,
                pressure,
                resistance_lever,
                0.0 if group in dynamics else other[:, group],
                speed,
                dynamics.get(group),
            )
    ideal = np.minimum(np.minimum(peak_adhesion, limit), alpha_max)
    share = peak_each * (ideal / peak_adhesion)[:, groups]

    columns = {
        "peak_slip": ("group", peak_slip, "slip of the greatest adhesion"),
        "peak_adhesion": ("group", peak_adhesion, "greatest adhesion of the rail"),
        "brake_limit": ("group", limit, f"adhesion that {force} brake pressure draws"),
        "ideal_adhesion": ("group", ideal, "adhesion of the ideal bound"),
        "ideal_share": ("wheelset", share, "share in the ideal bound"),
    }
    return trace.assign(
        {
            name: (("time", extent), values, {"units": "1", "long_name": meaning})
            for name, (extent, values, meaning) in columns.items()
        }
    )
