"""Bounds on the performance of any controller: the ideal bound, and controllers that know the true state.

A scenario selects one as the kind of its controller; sensors, estimator and controller are then not used.

In the stop of the ideal bound each group uses min(peak adhesion, brake limit, α_max) at every instant, and exceeds the
brake limit while its wheelsets regain the speed that a slide took from them. No controller that keeps to α_max stops in
a distance shorter by more than 0.1 %. No real controller reaches the bound, because pressure takes time to build up and
the peak must be found first. Where slip cleans the rail, the bound is optimistic (`railgrip.simulate.contact`), and
`tracking_stop` with given slips gives distances that a controller can reach. The train is integrated as a point mass;
the physics comes from the plant:

- peak adhesion from `RailBraking.FMUs.ContactPoint`, at the scenario's friction;
- pad friction from `RailBraking.Components.GroupBrake`, the highest that a controller can have;
- running resistance and the torque of other brakes on the wheelsets as functions of speed, and the transfer of load
  between wheelsets as a multiple of the deceleration, from a stop of the same plant with full brake on a rail with
  friction 0.6, where nothing slides. Pad friction of other plants than those of this library is from the same stop.

Pad friction is the highest that a controller can have along this stop. Pads have more friction after low force, at low
disc speed and on hot discs, and settle over friction work (`RailBraking.Friction.PadFriction`). The friction of a
group rises as fast, or falls as slowly, as one of these choices makes it:

- Where the rail limits the group, or dynamic brakes may relieve its pads: any force up to the full one, and any disc
  speed up to that of rolling.
- Where the brakes limit it: full force, and any disc speed that its wheelsets can have. Without a slide that is the
  speed of rolling less the slip at which the contact carries the brake; after a slide, less the slip behind the peak at
  which it does; and any, until the wheelsets have regained the speed of rolling. On a rail that slip cleans, any: the
  bound has the cleanest rail, and a wheelset may lock on a less clean one.

A controller may also press with less than full force where the brakes limit, to have more friction later, but it does
not gain by that: all effects together change friction by about a quarter, so that lost impulse returns in part only.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from types import MappingProxyType
from typing import Any, Final

import casadi as ca
import numpy as np
import xarray

from railgrip.base.arrays import Array
from railgrip.base.errors import ScenarioError
from railgrip.base.tables import TomlTable
from railgrip.controllers.observation import Observation
from railgrip.fmus.native import Model
from railgrip.report.stop import Stop
from railgrip.scenario.adhesion import profile_of
from railgrip.scenario.faults import READ_BY
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.profile import Constant
from railgrip.scenario.schema import Scenario
from railgrip.simulate.assembly import assemble, evaluate_stop
from railgrip.simulate.contact import SLIPS_OF_TWO_MAXIMA, CleanedContact, with_energy
from railgrip.simulate.loop.loop import Ending
from railgrip.simulate.named_models import compile_class
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.trace.bound import Contact, contact_at, peak, regained_adhesion, torque_beyond_pads
from railgrip.trace.recorder import Recorder
from railgrip.vehicle.brake import Brake
from railgrip.vehicle.signals import CURVE, PLANT

_GRIPPY = 0.6
_BUILD_UP = 0.2  # s that the pressure takes
_ROUNDS = 60
_CLOSE = 1e-3  # m; a thousandth of what a change of controller moves


def ideal_stop(scenario: Scenario, progress: Callable[[float], None] | None = None) -> Stop:
    """Return the stop of the ideal bound.

    Speed over time is found by iteration: the bound depends on speed (falling friction) and on position along the
    track.

    Raises:
        ScenarioError: There is sand, slip cleans a rail whose friction is over time, the plant does not output its
            brakes, or the iteration does not converge; it contracts if friction changes little with speed and position.
    """
    _require_known_rail(scenario)
    vehicle = VehicleData(scenario)
    formation, load, mass = vehicle.formation, vehicle.true.load, sum(vehicle.true.masses.tolist())
    speeds, friction, resistance, other, transfer = full_braking(vehicle, progress)
    period = scenario.periods.communication
    count = round(scenario.horizon / period) + 1
    time = np.arange(count, dtype=np.float64) * period
    profile, force = profile_of(scenario, formation), vehicle.track_force
    groups = formation.group_of_wheelset
    rotating_mass = np.array([0.0 if b is None else b.inertia / b.wheel_radius**2 for b in vehicle.true.brakes])
    lever = np.array([0.0 if b is None else b.units * b.friction_radius for b in vehicle.true.brakes])
    pad_force = np.array([0.0 if b is None else b.pad_force(b.pressure_max) for b in vehicle.true.brakes])
    recorder = Recorder((*PLANT, *vehicle.layout.signals["input"]), formation, count)
    recorder.rows[:] = np.nan  # most signals of a train do not exist for a point mass
    speed, distance, acceleration = _first_guess(scenario.start.speed, time)
    contact, of_rail = _rail(vehicle)
    pad_friction, bound = pads_of(vehicle, contact, speeds, friction), None
    for _ in range(_ROUNDS):
        at, rows = recorder.columns, recorder.rows
        _write_motion(recorder, distance, speed, acceleration)
        rows[:, at["mu0"]] = profile.table(time, distance)
        if (curve_numbers := profile.curve_numbers(time, distance)) is not None:
            for i, signal in enumerate(CURVE):
                rows[:, at[signal.name]] = vehicle.curves[curve_numbers, i]
        rows[:, at["wheelset_load"]] = load - transfer * acceleration[:, None]
        rows[:, at["pad_friction"]] = pad_friction(speed, bound)
        if other.any():
            # The torques that full brake draws, of which the bound takes what adhesion allows.
            rows[:, at["pad_force"]] = pad_force
            beyond_pads = np.stack([np.interp(speed, speeds, each) for each in other.T], axis=1)
            rows[:, at["brake_torque"]] = lever * rows[:, at["pad_friction"]] * pad_force + beyond_pads
        end = _end(speed, scenario.limits.stop_speed)
        moving = end or count
        bound = of_rail(recorder.trace(moving, period))
        ideal, share = bound["ideal_adhesion"].values, bound["ideal_share"].values
        loads = rows[:moving, at["wheelset_load"]]
        usable = np.minimum(bound["peak_adhesion"].values, scenario.limits.alpha_max)
        regained = regained_adhesion(
            time=time[:moving],
            speed=speed[:moving],
            usable=usable,
            limit=bound["brake_limit"].values,
            load=formation.sum_by_group(loads),
            rotating_mass=rotating_mass,
        )
        used = np.minimum(ideal + regained, usable)
        share = share * np.divide(used, ideal, out=np.ones_like(ideal), where=ideal > 0.0)[:, groups]
        slowing = (np.sum(share * loads, axis=1) + np.interp(speed[:moving], speeds, resistance)) / mass
        slowing -= force.at(distance[:moving]) / mass
        rows[:moving, at["adhesion"]] = share
        rows[:moving, at["group_adhesion"]] = used
        rows[:moving, at["slip"]] = bound["peak_slip"].values
        before = distance[end or -1]
        speed, distance, acceleration = _integrate(scenario.start.speed, slowing, count, period)
        end_index = _end(speed, scenario.limits.stop_speed)
        if bool(end_index) == bool(end) and abs(distance[end_index or -1] - before) < _CLOSE:
            break
    else:
        raise ScenarioError(
            f"[controller] ideal_bound found no best stop in {_ROUNDS} rounds: friction changes too much over "
            f"{period:g} s; shorten [periods] communication"
        )
    if isinstance(contact, CleanedContact):
        here, slip = contact_at(contact.friction, bound), bound["peak_slip"].values[:, groups]
        rows[:moving, at["mu0"]] = here(slip, speed[:moving, None], loads, rows[:moving, at["mu0"]])
    _write_motion(recorder, distance, speed, acceleration)
    samples = min(end_index or count - 1, moving - 1) + 1
    place = f"after {distance[samples - 1]:.2f} m and {time[samples - 1]:.3f} s at best."
    ending = Ending(
        outcome=Outcome.STANDSTILL if end_index else Outcome.HORIZON,
        reason=f"Could stop {place}" if end_index else f"Still rolls with {speed[samples - 1]:.2f} m/s {place}",
        samples=samples,
    )
    return evaluate_stop(vehicle, recorder, ending, {vehicle.file.file.name: vehicle.file})


def _require_known_rail(scenario: Scenario) -> None:
    """Raise an error for a rail whose change by slip depends on more than the place."""
    if scenario.sanders:
        raise ScenarioError(
            "[controller] ideal_bound is the best stop on a known rail, and with [[sanders]] the friction at a "
            "wheelset depends on the sand that those ahead left: remove one of them"
        )
    adhesion = scenario.adhesion
    if adhesion.cleaning is not None and not isinstance(adhesion, Constant) and not scenario.runs_over_distance:
        raise ScenarioError(
            "[controller] ideal_bound takes friction over distance where slip cleans the rail, because a place is then "
            "cleaned before a wheelset reaches it: leave out [adhesion.recovery], or give the friction "
            'over = "distance"'
        )


def _rail(vehicle: VehicleData) -> tuple[Contact, Callable[[xarray.Dataset], xarray.Dataset]]:
    """Return the contact on the rail of a scenario, and the function that returns a trace with the bound there."""
    cleaning = vehicle.scenario.adhesion.cleaning
    if cleaning is None:
        return vehicle.contact, partial(vehicle.bound, contact=vehicle.contact)
    contact = CleanedContact(vehicle.contact, cleaning, vehicle.curves[0])
    bound = partial(vehicle.bound, contact=contact, search=partial(peak, slips=SLIPS_OF_TWO_MAXIMA))
    return contact, lambda trace: bound(with_energy(trace, contact))


def full_braking(
    vehicle: VehicleData, progress: Callable[[float], None] | None
) -> tuple[Array, Array, Array, Array, Array]:
    """Return brakes, resistance and load transfer of a train, from a stop on its track without slides.

    Returns:
        Speeds, rising, shape (k,) [m/s]; pad friction of each group there, shape (k, groups); running resistance
        there, shape (k,) [N]; torque of other brakes on the wheelsets of each group there, shape (k, groups) [N.m];
        load that a wheelset gains with the deceleration, shape (wheelsets,) [kg].
    """
    with assemble(_full_brake(vehicle.scenario)) as parts:
        reference = parts.stop(parts.run(progress))
    truth = reference.trace.isel(time=slice(round(_BUILD_UP / vehicle.scenario.periods.communication), None))
    if reference.outcome is not Outcome.STANDSTILL or truth.sizes["time"] < 2:
        raise ScenarioError(
            f"[controller] ideal_bound takes the brakes from a stop with full brake on a rail of friction {_GRIPPY:g}, "
            f"which ended with {reference.outcome.value}: {reference.reason}"
        )
    order = np.argsort(truth["speed"].values)
    rail_force = np.sum(truth["adhesion"].values * truth["wheelset_load"].values, axis=1)
    load, mass = vehicle.true.load, sum(vehicle.true.masses.tolist())
    resistance = vehicle.track_force.at(truth["distance"].values) - mass * truth["acceleration"].values - rail_force
    deceleration = -truth["acceleration"].values
    transfer = deceleration @ (truth["wheelset_load"].values - load) / (deceleration @ deceleration)
    other = torque_beyond_pads(truth, vehicle.true.brakes)
    return truth["speed"].values[order], truth["pad_friction"].values[order], resistance[order], other[order], transfer


class KnownRail:
    """The known rail where the groups will be when a command that is sent now takes effect.

    Attributes:
        time: Time until the command takes effect [s].
    """

    def __init__(self, vehicle: VehicleData) -> None:
        """Look ahead on the rail of a scenario, by the dead time of its valves."""
        self._profile, self._formation = profile_of(vehicle.scenario, vehicle.formation), vehicle.formation
        self._contact, self._curves, self.time = vehicle.contact, vehicle.curves, 0.0
        if vehicle.scenario.actuation.kind == "pneumatic":
            self.time = max(vehicle.true.valves["dead_fill"], vehicle.true.valves["dead_vent"])

    def look(self, time: float, distance: float, speed: float, load: Array) -> tuple[Array, Array, Array]:
        """Return slip and adhesion to hold, and the peak adhesion over the present one, each of shape (groups,).

        Args:
            time: Since the start [s].
            distance: Of the leading wheelset [m].
            speed: Of the train [m/s].
            load: Of each wheelset [N].
        """
        times, places = np.array([time, time + self.time]), np.array([distance, distance + speed * self.time])
        friction, loads, speeds = self._profile.table(times, places), np.stack([load, load]), np.full(2, speed)
        numbers = self._profile.curve_numbers(times, places)
        found: list[tuple[float, float, float]] = []
        for members in self._formation.members():
            contact = self._contact
            if numbers is not None:
                contact = partial(contact, curve=np.moveaxis(self._curves[numbers[:, members]], -1, 0))
            wheel_load, rail = loads[:, members], friction[:, members]
            slip, each = peak(contact, speeds, wheel_load, rail)
            now, then = np.sum(each * wheel_load, axis=1)
            held = np.broadcast_to(_BELOW * slip[:, None], wheel_load.shape)
            most = np.sum(
                contact(held, np.broadcast_to(speeds[:, None], wheel_load.shape), wheel_load, rail) * wheel_load, axis=1
            )[1]
            found.append((_BELOW * slip[1], most / wheel_load[1].sum(), then / now))
        slips, adhesions, changes = np.array(found).T
        return slips, adhesions, changes


class _Tracking:
    """Controller that knows the true state: it holds the optimum slip of every group through the given actuation.

    With given slips it holds those, for any adhesion, and brakes fully a group whose slip is 1.

    From the torque balance of a group, J ω̇ = F r − T, with s = 1 − rω/v, slip approaches s* at the rate κ if

          T = F r + J/r (κ (s* − s) v − (1 − s) v̇),   F r limited by α_max

    s* is slightly below the slip at the peak of the creep curve at the time when the valves will have answered, so that
    the slide is stable. For slip below s*, F is the force of the curve at s*, so that the wheel gets there whatever the
    dead band of the valves leaves of the second term; above it, F is the true braking force, scaled by the predicted
    change of the peak. Real controllers do not have this information; a controller that anticipated the whole rail
    could still do slightly better.
    """

    def __init__(self, vehicle: VehicleData, recorder: Recorder, slips: Sequence[float] = ()) -> None:
        """Control the stop that is written to a recorder."""
        scenario, self._formation = vehicle.scenario, vehicle.formation
        self._rail, self._brakes = KnownRail(vehicle), vehicle.true.brakes
        self._recorder, self._period, self._limit = recorder, scenario.periods.communication, scenario.limits.alpha_max
        self._due, self._slip, self._most, self._change = 0.0, np.array(slips), np.zeros(0), np.zeros(0)
        self._is_held = len(slips) > 0

    def decide(self, observation: Observation) -> tuple[float, ...]:
        """Return the demanded pressure of each group [Pa]; only the time of the observation is used."""
        row, at = self._recorder.rows[round(observation.time / self._period)], self._recorder.columns
        speed, distance = float(row[at["speed"]][0]), float(row[at["distance"]][0])
        if speed < _SLOWEST:
            return tuple(0.0 if brake is None else brake.pressure_max for brake in self._brakes)
        load = row[at["wheelset_load"]]
        if observation.time >= self._due and not self._is_held:
            self._due = observation.time + _PEAK_PERIOD
            self._slip, self._most, self._change = self._rail.look(observation.time, distance, speed, load)
        group_load = self._formation.sum_by_group(load)
        slip, deceleration = row[at["slip"]], float(row[at["acceleration"]][0])
        adhesion = row[at["group_adhesion"]]
        if not self._is_held:
            adhesion = np.where(slip < self._slip, self._most, adhesion * self._change)
        turning = _RATE * (self._slip - slip) * speed - (1.0 - slip) * deceleration
        force = (np.minimum(adhesion, self._limit) * group_load).tolist()
        pressures: list[float] = []
        frictions, goals = row[at["pad_friction"]].tolist(), self._slip.tolist()
        for brake, held, turned, friction, goal in zip(
            self._brakes, force, turning.tolist(), frictions, goals, strict=True
        ):
            if brake is None:
                pressures.append(0.0)
                continue
            torque = held * brake.wheel_radius + brake.inertia / brake.wheel_radius * turned
            pressure = brake.pressure_of(torque / (brake.units * friction * brake.friction_radius))
            pressures.append(brake.pressure_max if goal >= 1.0 else min(max(pressure, 0.0), brake.pressure_max))
        return tuple(pressures)


_SLOWEST = 0.5  # m/s; below, slip is a ratio of two small numbers
_PEAK_PERIOD = 0.05  # s; friction of scenarios changes over tenths of a second
_RATE = 10.0  # 1/s; valves fill and vent within some tenths of a second, and their predictor looks ahead
_BELOW = 0.9  # of the slip of the peak; on published curves there is 99 % of its adhesion


def tracking_stop(
    scenario: Scenario, progress: Callable[[float], None] | None = None, slips: Sequence[float] = ()
) -> Stop:
    """Return the stop of a controller that knows the true state, with the actuation and the faults of the scenario.

    Args:
        scenario: Scenario of the stop.
        progress: Called with the train speed [m/s] at intervals.
        slips: Slip of each group to hold, 1 for locked wheels; without them the optimum.

    Raises:
        ScenarioError: The scenario requires something that its parts cannot do, or the plant does not output its
            brakes.
    """
    if VehicleData(scenario).dynamic_limits:
        raise ScenarioError(
            "[controller] ideal_tracking computes pressures of friction brakes alone, but [dynamic_brakes] of the "
            "train file brake, too; use ideal_bound"
        )
    faults = [fault.model_dump(mode="json") for fault in scenario.faults if fault.part not in READ_BY]
    with assemble(_bare(scenario, {"faults": faults})) as parts:
        controller = _Tracking(VehicleData(scenario), parts.recorder, slips)
        parts = replace(parts, parts=replace(parts.parts, controller=controller))
        ending = parts.run(progress)
    stop = parts.stop(ending)
    # It ran without the sensor faults, which a controller that knows the true state does not see.
    return replace(stop, inputs=scenario.resolved(), digest=scenario.digest(), parsed=scenario)


ANALYSES: Final[Mapping[str, Callable[[Scenario, Callable[[float], None] | None], Stop]]] = MappingProxyType(
    {"ideal_bound": ideal_stop, "ideal_tracking": tracking_stop}
)
"""Analysis by the name that a scenario gives it in [controller] kind."""


def _full_brake(scenario: Scenario) -> Scenario:
    """Return the same train and track, fully braked on a rail without slides."""
    changes: TomlTable = {"adhesion": {"kind": "constant", "mu0": _GRIPPY, "polach": "dry"}, "faults": []}
    return _bare(scenario, changes)


def _bare(scenario: Scenario, changes: TomlTable) -> Scenario:
    """Return a scenario with the tables in `changes`, fully braked without a controller."""
    parts = {"sensors": {"kind": "ideal"}, "estimator": {"kind": "none"}, "controller": {"kind": "full_brake"}}
    # Keys of the rail, such as patches, must not remain where the kind of friction is the same.
    return scenario.replaced(parts | changes)


def _write_motion(recorder: Recorder, distance: Array, speed: Array, acceleration: Array) -> None:
    for name, values in (("distance", distance), ("speed", speed), ("acceleration", acceleration)):
        recorder.rows[:, recorder.columns[name]] = values[:, None]


def _end(speed: Array, stop_speed: float) -> int:
    """Return the first sample at standstill, 0 if the train does not stop."""
    return int(np.argmax(speed <= stop_speed))


def _first_guess(start: float, time: Array) -> tuple[Array, Array, Array]:
    speed = np.maximum(start - 0.8 * time, 0.0)
    return speed, np.concatenate([[0.0], np.cumsum(speed[:-1]) * (time[1] - time[0])]), np.full(len(time), -0.8)


def _integrate(start: float, slowing: Array, count: int, period: float) -> tuple[Array, Array, Array]:
    """Integrate a deceleration over time by the trapezoidal rule; after its end its last value is held."""
    acceleration = -np.concatenate([slowing, np.full(count - len(slowing), slowing[-1])])
    steps = 0.5 * (acceleration[1:] + acceleration[:-1]) * period
    speed = np.maximum(start + np.concatenate([[0.0], np.cumsum(steps)]), 0.0)
    distance = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * period)])
    return speed, distance, acceleration


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

_OF_PADS = {"mu_b_start[1]", "speed_effect", "m_disc"}
"""Parameters of plants whose pads and discs are known."""

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


def pads_of(
    vehicle: VehicleData, contact: Contact, speeds: Array, friction: Array
) -> Callable[[Array, xarray.Dataset | None], Array]:
    """Return the function `PadLimits.friction` of a plant of this library, whose parameters describe pads and discs.

    Other plants have the friction of the table at each speed.

    Args:
        vehicle: Vehicle of the plant.
        contact: Contact on the rail of the bound.
        speeds: Rising speeds of the table, shape (k,) [m/s].
        friction: Pad friction there in a stop without slides, shape (k, groups).
    """
    if vehicle.train is not None or vehicle.true.parameters.keys() >= _OF_PADS:
        return PadLimits(vehicle, contact).friction

    def of_table(speed: Array, bound: xarray.Dataset | None) -> Array:  # pyright: ignore[reportUnusedParameter]
        return np.stack([np.interp(speed, speeds, each) for each in friction.T], axis=1)

    return of_table


def _model(vehicle: VehicleData, group: int) -> Model:
    """Return the class of the brake units of a group, with pads or with blocks."""
    has_blocks = vehicle.train is not None and vehicle.train.bogie_of(group).brake.blocks
    return compile_class(f"RailBraking.Components.{'TreadBrake' if has_blocks else 'GroupBrake'}")


def _parameters(vehicle: VehicleData, group: int) -> list[float]:
    """Return the parameters of the class for a group."""
    plant, pads = vehicle.true.parameters, dict[str, float]()
    if vehicle.train is not None:
        bogie = vehicle.train.bogie_of(group)
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
