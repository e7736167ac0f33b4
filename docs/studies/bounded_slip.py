"""Certify bounded slip: the share of the samples of the type test from which a release ends the slide of a wheelset.

Adhesion-based laws of this project release the brake above a slip, whatever they estimate. The certificate states from
where this is early enough. For a group with torque T, load N, wheel radius r, inertia J and train speed v

    ṡ ≤ c (T − r N α(s, t)),   c = r/(J v)

while the train slows. Three bounds hold over a horizon, during which the rail changes as in the trace:

    α(s', t) ≥ q μ0(t) − λ (s' − s)      for slips s' between s and b; q is the adhesion over friction at s
    T(t) ≤ T₁                            for the dead time τ of the vent valve, with what still fills
    Ṫ ≤ −R                               afterwards, down to the torque that the rail carries at b

With the mean friction μ̄ of the horizon, the excess E = T − r N (q μ̄ − λ (s' − s)) obeys Ė ≤ ΛE until τ and Ė ≤ ΛE − R
afterwards, where Λ = c r N λ. So the excess falls if the authority R of the brake is larger than what the fall of the
curve adds. The slip rises by no more than the integral of c E, and by c r N q m exp(ΛH) because friction changes, where
m is the largest integral of μ̄ − μ0 over a part of the horizon H:

    R > Λ E_τ,  E_τ = E₁ exp(Λτ),  E₁ = T₁ − r N q μ̄
    slip ≤ s + c (R t₁ − E₁)/Λ + c r N q m exp(ΛH),  t₁ = ln(R/(R − Λ E_τ))/Λ

The terms with μ̄ and m are the effect of ∂α/∂μ0·μ̇0. If the right-hand side does not exceed b, nor does slip, and the
bounds hold. It is evaluated for each b of a grid; docs/studies/adhesion_based.md has the proof. Assumptions: adhesion
over friction does not rise with friction, as with Polach's curve; the valve obeys; the rigging has no hysteresis; and
heat does not lower the friction.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

import railgrip as rg
from railgrip.base.arrays import Array
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.studies.type_test.case_set import case_named
from railgrip.studies.type_test.entrants import campaign_of, entrants, train_of, trains_of
from railgrip.trace.bound import Contact
from railgrip.trace.measures import FAST
from railgrip.trace.recorder import formation_in
from railgrip.vehicle.brake import Brake

STRIDE = 0.01
"""Time between two evaluated samples [s]."""
HORIZON = 0.6
"""Time over which the release must return the wheelset [s]."""
_SLIPS = np.geomspace(2e-3, 0.98, 30)
_FLAT = 1e-6  # 1/s, growth of the excess below which the curve counts as flat


@dataclass(frozen=True, slots=True, kw_only=True)
class BrakeRelease:
    """How fast the brake of one group releases, at each sample; all arrays have the shape (n,).

    Attributes:
        torque: Upper bound of the torque until venting begins [N.m].
        dead_time: From the command to the flow of the vent valve [s].
        torque_per_pressure: Of the brake [N.m/Pa].
        offset: Pressure at which the pads touch [Pa].
        vent_time: Time constant of venting [s].
        choked: Rate of pressure through the choked valve [Pa/s].
    """

    torque: Array
    dead_time: float
    torque_per_pressure: Array
    offset: float
    vent_time: float
    choked: float

    def rate_at(self, torque: Array) -> Array:
        """Return the rate at which the torque falls when it has fallen to a value [N.m/s]."""
        flow = (np.maximum(torque, 0.0) / self.torque_per_pressure + self.offset) / self.vent_time
        return self.torque_per_pressure * flow / (1.0 + (flow / self.choked) ** 8) ** 0.125


@dataclass(frozen=True, slots=True, kw_only=True)
class RailAhead:
    """What the rail carries over the horizon, at each sample.

    Attributes:
        slip: Present slip, shape (n,).
        force: Lower bound of the braking force with mean friction, at the present slip, shape (n,) [N].
        shortfall: Largest impulse that the changing friction takes away from this force, shape (n,) [N.s].
        slips: Grid of slips, shape (k,).
        fall: Largest fall of the force from the present slip to each slip of the grid, over the difference of the
            slips, 0 below the present slip, shape (k, n) [N].
        gain: r/(J v), at the lowest speed of the horizon, shape (n,) [1/(N.m.s)].
        wheel_radius: Of the group [m].
    """

    slip: Array
    force: Array
    shortfall: Array
    slips: Array
    fall: Array
    gain: Array
    wheel_radius: float


def slip_bound(rail: RailAhead, release: BrakeRelease, horizon: float = HORIZON) -> Array:
    """Return the bound of the slip after a release of the brake at each sample, NaN where no bound follows, (n,)."""
    best = np.full(rail.slip.shape, np.nan)
    radius, gain = rail.wheel_radius, rail.gain
    excess = release.torque - radius * rail.force
    steepest = np.zeros_like(rail.slip)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for highest, fall in zip(rail.slips, rail.fall, strict=True):
            steepest = np.maximum(steepest, fall)
            growth = np.maximum(gain * radius * steepest, _FLAT)
            lowest = radius * (rail.force - steepest * (highest - rail.slip))
            rate = np.where(lowest > 0.0, release.rate_at(lowest), 0.0)
            before = excess * np.exp(growth * release.dead_time)
            duration = -np.log1p(-growth * before / rate) / growth
            rise = gain * (rate * duration - excess) / growth
            holds = (rate > growth * before) & (release.dead_time + duration <= horizon)
            rise = np.where(excess > 0.0, np.where(holds, rise, np.inf), 0.0)
            bound = rail.slip + rise + gain * radius * rail.shortfall * np.exp(growth * horizon)
            valid = (highest > rail.slip) & (bound <= highest)
            best = np.where(valid, np.fmin(best, bound), best)
    return best


def with_certificate(
    trace: xarray.Dataset, contact: Contact, brakes: Sequence[Brake | None], valves: Mapping[str, float], window: float
) -> xarray.Dataset:
    """Return the certificate of a stop with valves and one creep curve, every `STRIDE`.

    Variables (time, group):

    - `slip`
    - `slip_bound`: bound after a release, NaN where none follows
    - `slip_reached`: largest slip while a release from this sample lasted, NaN where the valves did not vent
    - `adhesion_by_slip`: change over the next `window` by that of slip, on the present rail
    - `adhesion_by_rail`: change by that of friction, speed and load, at the present slip; the law of the paper sees the
      sum of both and takes it for the former

    Args:
        trace: All samples of the stop.
        contact: The creep curve.
        brakes: Of each group, None if isolated.
        valves: Dead times and time constants by the names of the plant's parameters [s], and `rate_choked`, the rate of
            pressure through the choked vent valve [Pa/s].
        window: Time over which a law compares adhesion and slip [s].
    """
    period = float(trace["time"].values[1] - trace["time"].values[0])
    step, ahead = max(1, round(STRIDE / period)), round(HORIZON / STRIDE)
    samples = round(valves["dead_fill"] / period) + 2  # of commands that are under way
    fills = _ahead(trace["command"].values[::-1] >= 0.5, samples - 1, constant_values=False)[::-1]
    filling = fills[::step].sum(axis=-1) * period
    rows = trace.isel(time=slice(0, None, step))
    speed = rows["speed"].values
    count, groups = rows["slip"].shape
    then = np.minimum(np.arange(count) + max(1, round(window / STRIDE)), count - 1)
    names = ("slip_bound", "adhesion_by_slip", "adhesion_by_rail")
    results = {name: np.full((count, groups), np.nan) for name in names}
    results["slip_reached"] = _reached(rows["slip"].values, rows["command"].values <= -0.5, ahead)
    for group, members in enumerate(formation_in(trace).members()):
        brake = brakes[group]
        if brake is None:
            continue
        load, friction = rows["wheelset_load"].values[:, members], rows["mu0"].values[:, members]
        slip = rows["slip"].values[:, group]
        release = _release(rows, group, brake, valves, filling[:, group])
        rail = _rail(contact, brake, slip, speed, load, friction, ahead)
        results["slip_bound"][:, group] = slip_bound(rail, release)
        present = _force(contact, slip, speed, load, friction) / load.sum(axis=1)
        by_slip = _force(contact, slip[then], speed, load, friction) / load.sum(axis=1)
        by_rail = _force(contact, slip, speed[then], load[then], friction[then]) / load[then].sum(axis=1)
        results["adhesion_by_slip"][:, group] = by_slip - present
        results["adhesion_by_rail"][:, group] = by_rail - present
    values = {name: (("time", "group"), array) for name, array in results.items()}
    return xarray.Dataset({"slip": rows["slip"], **values}, coords={"time": rows["time"]})


def _ahead(values: Array, count: int, **padding: Any) -> Array:
    """Return each value and the next `count` ones along the first axis, of which the last value follows the end."""
    padded = np.pad(values, [(0, count)] + [(0, 0)] * (values.ndim - 1), **(padding or {"mode": "edge"}))
    return sliding_window_view(padded, count + 1, axis=0)


def _reached(slip: Array, venting: NDArray[np.bool_], ahead: int) -> Array:
    """Return the largest slip of each sample and the next `ahead` ones while the valves vent, NaN where they do not."""
    lasts = np.logical_and.accumulate(_ahead(venting, ahead, constant_values=False), axis=-1)
    return np.where(venting, np.where(lasts, _ahead(slip, ahead), -np.inf).max(axis=-1), np.nan)


def _release(
    rows: xarray.Dataset, group: int, brake: Brake, valves: Mapping[str, float], filling: Array
) -> BrakeRelease:
    """Return the release of a group; `filling` is the time of the last commands to fill that are under way [s]."""
    pad = rows["pad_friction"].values[:, group]
    pad_friction = _ahead(pad, round(HORIZON / STRIDE)).max(axis=-1)
    pressure = rows["cylinder_pressure"].values[:, group]
    per_pressure = brake.units * pad_friction * brake.friction_radius * brake.rigging * brake.piston_area
    filled = np.minimum(filling / valves["T_fill"], 1.0) * (brake.pressure_max - pressure)
    offset = brake.spring_force / brake.piston_area
    return BrakeRelease(
        torque=per_pressure * np.maximum(pressure + filled - offset, 0.0),
        dead_time=valves["dead_vent"] + 2e-3,
        torque_per_pressure=per_pressure,
        offset=offset,
        vent_time=valves["T_vent"],
        choked=valves["rate_choked"],
    )


def _rail(
    contact: Contact, brake: Brake, slip: Array, speed: Array, load: Array, friction: Array, ahead: int
) -> RailAhead:
    loads, slowest = _ahead(load, ahead), _ahead(speed, ahead).min(axis=-1)
    highest, lowest_load, heaviest = _ahead(friction, ahead).max(axis=-1), loads.min(axis=-1), loads.max(axis=-1)
    share = contact(slip[:, None], speed[:, None], lowest_load, highest) / highest
    force, shortfall = np.zeros_like(slip), np.zeros_like(slip)
    for member in range(load.shape[1]):
        mean, impulse = _mean_and_shortfall(friction[:, member], ahead)
        carried = share[:, member] * lowest_load[:, member]
        force, shortfall = force + carried * mean, shortfall + carried * impulse
    forces = np.stack([_force(contact, at, speed, heaviest, highest) for at in (slip, *_SLIPS)])
    above = _SLIPS[:, None] > slip
    fall = np.where(above, (forces[0] - forces[1:]) / np.where(above, _SLIPS[:, None] - slip, 1.0), 0.0)
    return RailAhead(
        slip=slip,
        force=force,
        shortfall=shortfall,
        slips=_SLIPS,
        fall=np.maximum(fall, 0.0),
        gain=brake.wheel_radius / (brake.inertia * np.maximum(slowest, 0.1)),
        wheel_radius=brake.wheel_radius,
    )


def _force(contact: Contact, slip: Array | float, speed: Array, load: Array, friction: Array) -> Array:
    return np.sum(contact(np.broadcast_to(slip, speed.shape)[:, None], speed[:, None], load, friction) * load, axis=1)


def _mean_and_shortfall(friction: Array, ahead: int) -> tuple[Array, Array]:
    """Return the mean over the horizon, and the largest integral [s] of what lacks to it in any part of the horizon."""
    course = _ahead(friction, ahead - 1)
    mean = course.mean(axis=-1)
    lacking = np.cumsum((mean[:, None] - course) * STRIDE, axis=-1)
    return mean, np.max(lacking - np.minimum.accumulate(np.minimum(lacking, 0.0), axis=-1), axis=-1)


FAMILIES = ("over", "rail", "cleaning", "number of faults", "train", "mechanics")
"""Variants of a case of version 2 of the type test that make families."""
SLIDING = 0.01
"""Slip above which a sample counts; errors of wheel radius and speed are up to half of it in most cases."""
TOLERANCE = 2e-3
"""Slip by which a bound may be exceeded: friction between two samples is not known to it."""
WINDOW = 0.2
"""Time over which the tuned adhesion-based law keeps a direction (its `dwell`) [s]."""
CHOKED = 15e5
"""Rate of pressure through a choked vent valve, where a plant does not set it [Pa/s]."""


def count_of(stop: rg.Stop) -> dict[str, int]:
    """Return counts of the sliding samples of a stop above 15 km/h, of all groups with brakes.

    `sliding`; `inside`, with a bound; `released`, inside with venting valves; `exceeded`, of these with more slip than
    the bound; `slope visible`, in which slip changes adhesion by more than the rail does; `slope significant`, in which
    it does so by more than the rail and the deviation that the filter claims together.
    """
    vehicle = VehicleData(stop.scenario)
    true = vehicle.true
    valves = {**true.valves, "rate_choked": true.parameters.get("rate_choked", CHOKED)}
    found = with_certificate(stop.trace, vehicle.contact, true.brakes, valves, WINDOW)
    rows = stop.trace.sel(time=found["time"])
    has_brake = np.array([brake is not None for brake in true.brakes])
    sliding = (found["slip"].values > SLIDING) & (rows["speed"].values > FAST)[:, None] & has_brake
    bound, reached = found["slip_bound"].values, found["slip_reached"].values
    inside = sliding & np.isfinite(bound)
    released = inside & np.isfinite(reached)
    by_slip, by_rail = np.abs(found["adhesion_by_slip"].values), np.abs(found["adhesion_by_rail"].values)
    masks = {
        "sliding": sliding,
        "inside": inside,
        "released": released,
        "exceeded": released & (reached > bound + TOLERANCE),
        "slope visible": sliding & (by_slip > by_rail),
        "slope significant": sliding & (by_slip > by_rail + rows["estimate_adhesion_sd"].values),
    }
    return {name: int(np.count_nonzero(mask)) for name, mask in masks.items()}


def row(case: str, law: str) -> dict[str, Any]:
    """Run a case of version 2 of the type test under one of its entrants; return its families and `count_of` the stop.

    Args:
        case: Name of the case, which contains its set.
        law: Name of the entrant.
    """
    design = [case_named(case)]
    (stop,) = campaign_of(design, {law: entrants(2)[law]}, train_of(None), trains=trains_of(design)).stops
    return {name: stop.variants[name] for name in FAMILIES} | count_of(rg.run(stop.scenario))
