"""The stopping distance of a dry train by hand calculation, without slip, suspension and wheel-slide protection.

Source: EN 14531-1, stopping distance by time steps from instantaneous forces; it does not consider adhesion.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import accumulate
from math import inf, pi, sqrt
from typing import Any, cast

import numpy as np

from railgrip.base.arrays import Matrix, Vector
from railgrip.base.errors import InputError
from railgrip.base.units import GRAVITY
from railgrip.rolling_stock.brakes import CONSTANT, SHAPE, BlockLaw
from railgrip.rolling_stock.schema import BrakePipe, Electropneumatic, Stages, Train
from railgrip.scenario.table import Table

_STEP = 1e-2  # s
_FILLED = 0.95  # share of the highest pressure at the end of the filling time
_SOUND = (
    290.0  # m/s, isothermal, of a small wave in a pipe without branches; UIC 540 requires 250 m/s of the brake front
)
_AIR_DENSITY = 1.2  # kg/m3, as in RailBraking.Data.Drag
_MAX_DURATION = 600.0  # s


@dataclass(frozen=True, slots=True, kw_only=True)
class HandCalculation:
    """Result of the hand calculation.

    Attributes:
        distance: Distance from the brake demand to standstill [m].
        duration: Time from the brake demand to standstill [s].
        deceleration: Mean deceleration over the distance of a stop with fully developed brakes [m/s2].
        equivalent_time: Equivalent response time [s]: this time at the initial speed, and then a stop with fully
            developed brakes, give the same distance (EN 14531-1), s = v te + v²/(2 a).
        adhesion: Maximum adhesion used by each axle, shape (axles,); coupled axles share their brake forces.
        rotating_mass: Equivalent mass of the rotating parts [kg].
        coupler_force: Maximum force in each coupler, compression positive, shape (cars - 1,) [N].
        car_force: Brake force on each car in the middle of each step, shape (steps, cars) [N].
        car_mass: Mass of each car with its rotating parts, shape (cars,) [kg].
        dynamic_work: Work of electrodynamic and eddy-current brakes [J].
    """

    distance: float
    duration: float
    deceleration: float
    equivalent_time: float
    adhesion: Vector
    rotating_mass: float
    coupler_force: Vector
    car_force: Vector
    car_mass: Vector
    dynamic_work: float


def by_hand(train: Train, speed: float, *, dynamic: bool = True) -> HandCalculation:
    """Return the emergency stop of a train on level dry track.

    Args:
        train: The train.
        speed: Speed at the brake demand [m/s].
        dynamic: Whether electrodynamic and eddy-current brakes act; friction brakes replace those that relieve them.

    Raises:
        InputError: The train does not stop within ten minutes.
    """
    stop, developed = (_stop(train, speed, developed=is_developed, dynamic=dynamic) for is_developed in (False, True))
    return replace(
        stop,
        deceleration=speed**2 / (2 * developed.distance),
        equivalent_time=(stop.distance - developed.distance) / speed,
    )


# A command checks a train several times, and a study needs the same stops; they take longer than reading the file.
@lru_cache(maxsize=32)
def _stop(train: Train, speed: float, *, developed: bool, dynamic: bool) -> HandCalculation:
    """Return a stop whose brakes build up, or are `developed` from the start; its arrays are read-only."""
    brakes, wheel = brakes_of(train)
    mass, turning, shares = rotating_masses(train)
    rolling = mass * GRAVITY * _rolling(train, wheel)
    inert = float(mass.sum() + turning.sum())
    of_car = np.array([axle.car for axle in train.axles])
    cars = (of_car == np.arange(len(train.cars))[:, None]).astype(float)  # a row per car, 1 for each of its axles
    on_rail = [(b.cars[0], brake) for b, _, brake in train.rail_brakes if dynamic or not brake.is_dynamic]
    car_of_rail = np.array([car for car, _ in on_rail], dtype=np.intp)
    # Equal brakes have equal forces: a long train has few kinds.
    kinds = list({id(brake): brake for _, brake in on_rail}.values())
    kind_of_rail = np.array([next(i for i, kind in enumerate(kinds) if kind is b) for _, b in on_rail], dtype=np.intp)
    rims = _RimForces(train, brakes, dynamic=dynamic)
    build_up = _PressureBuildUp(train, speed)
    head_start = inf if developed else 0.0
    v, s, t, taken = speed, 0.0, 0.0, 0.0
    since = np.zeros(len(kinds))  # when they could be lowered
    adhesion, joints = np.zeros(mass.size), np.zeros(len(train.cars) - 1)
    history: list[Vector] = []
    car_mass = cars @ (mass + turning)
    while v > 0:
        now = t + _STEP / 2 + head_start  # forces in the middle of a step
        friction, electric, _ = rims.at(v, build_up.share(now, v), inf if developed else _STEP)
        braking = friction + electric + rolling
        since = np.where([v > kind.speed_max for kind in kinds], t + _STEP, since)
        each = [kind.force_after(now - begin, v) for kind, begin in zip(kinds, since.tolist(), strict=True)]
        rail = np.array(each, dtype=float)[kind_of_rail]
        drag = _drag(train, v)
        deceleration = (float(braking.sum()) + float(rail.sum()) + drag) / inert
        adhesion = np.maximum(adhesion, shares @ (braking - turning * deceleration))
        # The force of a coupler is the brake force of the cars ahead, less the force for their common deceleration.
        of_cars = cars @ braking + drag / len(train.cars)
        np.add.at(of_cars, car_of_rail, rail)
        history.append(of_cars)
        surplus = np.cumsum(of_cars - car_mass * deceleration)[:-1]
        joints = np.where(np.abs(surplus) > np.abs(joints), surplus, joints)
        last = deceleration * _STEP >= v
        step = v / deceleration if last else _STEP
        way = v * step - 0.5 * deceleration * step**2
        s += way
        eddy = sum(rail[i] for i, (_, brake) in enumerate(on_rail) if brake.is_dynamic)
        taken += (float(electric.sum()) + eddy) * way
        v = 0.0 if last else v - deceleration * step
        t += step
        _require_end(train, speed, t)
    car_force = np.array(history)
    for array in (adhesion, joints, car_force, car_mass):
        array.setflags(write=False)
    return HandCalculation(
        distance=s,
        duration=t,
        deceleration=speed**2 / (2 * s),
        equivalent_time=0.0,
        adhesion=adhesion,
        rotating_mass=float(turning.sum()),
        coupler_force=joints,
        car_force=car_force,
        car_mass=car_mass,
        dynamic_work=float(taken),
    )


def scattered_distances(train: Train, speed: float, deviations: Mapping[str, Matrix]) -> Vector:
    """Return the distances of emergency stops whose brakes deviate from their data, by time steps, shape (draws,) [m].

    Args:
        train: The train.
        speed: Speed at the brake demand [m/s].
        deviations: Every `Quantity` of a dispersion → factor of each draw and axle on its nominal value, or difference
            of its highest pressure [Pa], shape (draws, axles). `build_up` is a factor on all times of the build-up.

    Raises:
        InputError: The train has dynamic brakes that are blended or added at its axles, or a draw does not stop within
            ten minutes.
    """
    if train.dynamic_groups:
        raise InputError(
            f"{train.name}: stops with drawn brakes know friction brakes and brakes on the rail, but its axles have "
            "[dynamic_brakes]; leave out --draws, or dynamic_brake of [bogies] for a stop with friction brakes alone"
        )
    brakes, wheel = brakes_of(train)
    for name in ("pad_friction", "efficiency"):
        brakes[name] = brakes[name] * deviations[name]
    brakes["pressure_max"] = brakes["pressure_max"] + deviations["pressure"]
    for name in ("lever", "sliding"):
        brakes[name] = brakes[name] * deviations["friction_radius"] / deviations["wheel_radius"]
    mass, inertia = np.array([[axle.mass, axle.inertia] for axle in train.axles]).T
    drawn_wheel = wheel * deviations["wheel_radius"]
    drawn_mass = mass * deviations["mass"]
    inert = (drawn_mass + inertia / drawn_wheel**2).sum(axis=1)
    rolling = (drawn_mass * GRAVITY * _rolling(train, wheel)).sum(axis=1)
    slower = deviations["build_up"]
    on_rail = [(brake, bogie.axles[0]) for bogie, _, brake in train.rail_brakes]
    build_up = _PressureBuildUp(train, speed)
    v, s, t = np.full(len(inert), speed), np.zeros(len(inert)), 0.0
    since = np.zeros((len(on_rail), len(inert)))  # when they could be lowered
    while v.any():
        now = (t + _STEP / 2) / slower
        pads = _pad_force(brakes, build_up.share(now, v[:, None]) * brakes["pressure_max"])
        force = _friction_force(brakes, v[:, None], pads).sum(axis=1) + rolling + _drag(train, v)
        for place, (brake, axle) in enumerate(on_rail):
            since[place] = np.where(v > brake.speed_max, (t + _STEP) / slower[:, axle], since[place])
            force += deviations["track_brake"][:, axle] * brake.force_after(now[:, axle] - since[place], v)
        deceleration = force / inert
        last = deceleration * _STEP >= v
        step = np.where(last, v / np.maximum(deceleration, 1e-12), _STEP)
        s += v * step - 0.5 * deceleration * step**2
        v = np.where(last, 0.0, v - deceleration * step)
        t += _STEP
        _require_end(train, speed, t)
    return s


def developed_deceleration(train: Train, speed: float, *, dynamic: bool = True) -> tuple[Vector, Vector]:
    """Return speeds, falling [m/s], and decelerations [m/s2] of a stop with fully developed brakes.

    Args:
        train: The train.
        speed: Speed at the brake demand [m/s].
        dynamic: As for `by_hand`.

    Raises:
        InputError: The train does not stop within ten minutes.
    """
    stop = _stop(train, speed, developed=True, dynamic=dynamic)
    deceleration = stop.car_force.sum(axis=1) / stop.car_mass.sum()
    return speed - _STEP * (np.cumsum(deceleration) - deceleration / 2), deceleration


def _drag(train: Train, speed: Any) -> Any:
    """Return the part of the running resistance that rises with speed [N]; numbers or arrays."""
    of_air = 0.5 * _AIR_DENSITY * train.physics.drag_coefficient * train.physics.frontal_area
    return train.linear_resistance * speed + of_air * speed**2


def full_brake_force(train: Train) -> Vector:
    """Return the force at the rim with full pressure and nominal pad friction, of each axle, shape (axles,) [N]."""
    brakes, _ = brakes_of(train)
    return brakes["lever"] * brakes["pad_friction"] * _pad_force(brakes, brakes["pressure_max"])


def parking_forces(train: Train) -> Vector:
    """Return the force at the rim with which the parking brake can hold each axle, shape (axles,) [N]."""
    forces: list[float] = []
    for axle in train.axles:
        bogie = train.bogies_in_train[axle.bogie].data
        unit = train.parking_brakes[bogie.parking_brake] if bogie.parking_brake else None
        each = 0.0 if unit is None else unit.force * unit.friction * unit.friction_radius / bogie.wheel_radius
        forces.append(axle.parking_units * each)
    return np.array(forces)


def rotating_masses(train: Train) -> tuple[Vector, Vector, Matrix]:
    """Return mass and equivalent rotating mass of each axle [kg], and the matrix from rim forces to used adhesion.

    Shapes (axles,), (axles,), (axles, axles) [1/N]; coupled axles share their forces.
    """
    _, wheel = brakes_of(train)
    mass, inertia = np.array([[axle.mass, axle.inertia] for axle in train.axles]).T
    return mass, inertia / wheel**2, _shares_of_load(train, mass)


@dataclass(frozen=True, slots=True, kw_only=True)
class DevelopedForces:
    """Forces of developed brakes at a speed.

    Attributes:
        friction: Rim force of the friction brakes of each axle, shape (axles,) [N].
        dynamic: Rim force of the electrodynamic and rotating eddy-current brakes of each axle, shape (axles,) [N].
        left: Share of the pad force that is left to the friction brakes of each axle, shape (axles,).
        rail: Force of each brake on the rail itself [N].
        resistance: Running resistance [N].
    """

    friction: Vector
    dynamic: Vector
    left: Vector
    rail: Vector
    resistance: float


def developed_forces(train: Train, start: float, *, dynamic: bool = True) -> Callable[[float], DevelopedForces]:
    """Return the forces of developed brakes as a function of the speed [m/s] in a stop from `start` [m/s].

    Without `dynamic` friction brakes replace electrodynamic and eddy-current brakes where they are relieved by them.
    """
    brakes, wheel = brakes_of(train)
    stages = _stages_of(train)
    mass = np.array([axle.mass for axle in train.axles])
    rolling = float((mass * GRAVITY * _rolling(train, wheel)).sum())
    rims = _RimForces(train, brakes, dynamic=dynamic)
    on_rail = [brake for *_, brake in train.rail_brakes]

    def at(speed: float) -> DevelopedForces:
        shares = stage_shares(stages, start, speed)
        friction, electric, left = rims.at(speed, shares, inf)
        rail = [b.force_after(inf, speed) if dynamic or not b.is_dynamic else 0.0 for b in on_rail]
        resistance = rolling + _drag(train, speed)
        return DevelopedForces(
            friction=friction, dynamic=electric, left=left, rail=np.array(rail), resistance=resistance
        )

    return at


def response_times(train: Train) -> tuple[Vector, Vector]:
    """Return the equivalent response time of the friction brakes of each axle, and of each brake on the rail [s].

    It is the time integral of what the pressure lacks of the full one: delay and time constant, or delay of the wave in
    the pipe and half of the time of the linear rise, of which an inshot leaves (1 - inshot)² at the same rate.
    """
    delay, time, inshot = _build_up_of(train)
    if isinstance(train.command, BrakePipe):
        time = time / (_FILLED - inshot) * (1 - inshot) ** 2 / 2
    return delay + time, np.array([brake.dead_time + brake.time_constant for *_, brake in train.rail_brakes])


def stage_shares(stages: Sequence[Stages | None], start: float, speed: float) -> Vector:
    """Return the pressure behind distributors over the highest, shape (distributors,).

    Args:
        stages: Stages of each distributor; None for a single one.
        start: Speed at the brake demand [m/s].
        speed: Present speed [m/s].
    """
    return np.array(
        [1.0 if d is None or (start >= d.speed_up and speed >= d.speed_down) else d.low_share for d in stages]
    )


def _require_end(train: Train, speed: float, time: float) -> None:
    if time > _MAX_DURATION:
        raise InputError(
            f"by hand calculation the brakes do not stop {train.name} from {3.6 * speed:g} km/h within "
            f"{_MAX_DURATION:g} s; correct [brakes] or [pads]"
        )


def _shares_of_load(train: Train, mass: Vector) -> Matrix:
    """Return a row per axle: the reciprocal of the load of its group for each axle of the group [1/N], otherwise 0."""
    shares = np.zeros((mass.size, mass.size))
    for members in train.groups:
        shares[np.ix_(members, members)] = 1.0 / (mass[list(members)].sum() * GRAVITY)
    return shares


def brakes_of(train: Train) -> tuple[dict[str, Vector], Vector]:
    """Return the data of the brake units at each axle by their names, and the wheel radii [m], shape (axles,) each.

    `sliding` is the speed of the pads over that of the train, and `lever` the force at the rim over that of the
    friction of one unit.
    """
    parts = [train.bogies_in_train[axle.bogie] for axle in train.axles]
    wheel = _each([part.data for part in parts], "wheel_radius")
    brakes = {name: _each([part.brake for part in parts], name) for name in ("friction_radius", *_BRAKE)}
    brakes |= {name: _each([part.pads for part in parts], name) for name in _PAD_EFFECTS}
    brakes |= {name: np.array([getattr(part.law, name) for part in parts]) for name in SHAPE}
    if any(part.law is not CONSTANT for part in parts):
        brakes["nominal_shape"] = law_of(brakes).shape(brakes["speed_nominal"], brakes["force_nominal"])
    units = np.array([axle.units for axle in train.axles])
    radius = brakes["friction_radius"]
    return brakes | {"sliding": radius / wheel, "lever": units * radius / wheel}, wheel


def chain_forces(train: Train, stop: HandCalculation) -> Vector:
    """Return the maximum force in each coupler of a chain of oscillating cars, shape (couplers,) [N].

    The cars are rigid masses on the springs, dampers and slacks of their couplers, under the forces of the calculation
    by hand. A step of force makes one spring overshoot its static force by 1 + exp(-π ζ/√(1 - ζ²)), up to twice;
    a reversal of the force while the chain still oscillates adds to it.
    """
    body_of_car = list(accumulate((int(car.coupler is not None) for car in train.cars[:-1]), initial=0))
    couplers = [train.couplers[car.coupler] for car in train.cars if car.coupler]
    count = len(couplers)
    if not count:
        return np.zeros(0)
    from scipy.integrate import solve_ivp  # a quarter of the start of a stop, which does not need it

    of_body = np.array([[float(number == body) for number in body_of_car] for body in range(count + 1)])
    mass, force = of_body @ stop.car_mass, stop.car_force @ of_body.T
    stiffness, damping, slack = (_each(couplers, name) for name in ("stiffness", "damping", "slack"))

    def tension(state: Vector) -> Vector:
        stretch = np.sign(state[:count]) * np.maximum(np.abs(state[:count]) - slack / 2, 0.0)
        return stiffness * stretch - damping * np.diff(state[count:]) * ((stretch != 0) | (slack == 0))

    def rate(time: float, state: Vector) -> Vector:
        coupler_force = tension(state)
        braking = force[min(int(time / _STEP), len(force) - 1)]
        pull = np.append(0.0, coupler_force) - np.append(coupler_force, 0.0)
        return np.concatenate((-np.diff(state[count:]), (pull - braking) / mass))

    begin = np.zeros(2 * count + 1)
    solution = solve_ivp(rate, (0.0, len(force) * _STEP), begin, rtol=1e-6, atol=1e-7, max_step=_STEP)
    return np.abs(np.apply_along_axis(tension, 0, solution.y)).max(axis=1)


def _front_speed(train: Train, command: BrakePipe) -> float:
    """Return the speed of a small wave in the brake pipe [m/s], which the branches slow down."""
    pipe = pi / 4 * command.diameter**2 * sum(car.length for car in train.cars)
    return _SOUND / sqrt(1 + command.branch_volume * len(train.cars) / pipe)


def _pad_force(brakes: dict[str, Vector], pressure: Vector) -> Vector:
    """Return the normal force of both pads of a unit [N]."""
    at_piston = np.maximum(pressure * brakes["piston_area"] - brakes["spring_force"], 0.0)
    return brakes["efficiency"] * brakes["rigging"] * at_piston


class _RimForces:
    """Forces at the rims of the axles: friction brakes, and dynamic brakes that relieve them or add to them.

    The equations are those of RailBraking.Components.PressureBlending.
    """

    def __init__(self, train: Train, brakes: dict[str, Vector], *, dynamic: bool) -> None:
        self._brakes, self._across = brakes, train.blends_across
        self._groups = train.dynamic_groups if dynamic else ()
        of_group = np.array([axle.group for axle in train.axles])
        self._valve_of_axle = np.array(train.valve_of_group)[of_group]
        self._valves = len(train.groups_per_valve)
        self._valve = np.array([each.valve for each in self._groups], dtype=np.intp)
        self._first = np.array([train.groups[each.group][0] for each in self._groups], dtype=np.intp)
        self._adds = np.array([each.brake.blending == "added" for each in self._groups], dtype=bool)
        # Groups with equal brakes have equal forces: a long train has few kinds.
        keys = [(id(each.brake), each.units, each.load) for each in self._groups]
        self._alike = [self._groups[keys.index(key)] for key in dict.fromkeys(keys)]
        self._kind = np.array([list(dict.fromkeys(keys)).index(key) for key in keys], dtype=np.intp)
        self._time = np.array([each.brake.time_constant for each in self._groups])
        units = np.array([axle.dynamic_units for axle in train.axles], dtype=float)
        # Column per group: the part of its force on each axle.
        self._parts = np.array([np.where(of_group == each.group, units, 0.0) / each.units for each in self._groups]).T
        self._lagged = np.zeros(len(self._groups))

    def at(self, speed: float, share: Vector, step: float) -> tuple[Vector, Vector, Vector]:
        """Return friction and dynamic force of each axle [N], and the share of its pad force that is left to friction.

        Those after a step [s] at a speed [m/s], with shares of the highest pressure.
        """
        brakes = self._brakes
        pads = _pad_force(brakes, share * brakes["pressure_max"])
        if not self._groups:
            return _friction_force(brakes, speed, pads), np.zeros(pads.size), np.ones(pads.size)
        of_axle = brakes["lever"] * brakes["pad_friction"] * pads
        demand = np.bincount(self._valve_of_axle, of_axle, self._valves)
        available = np.array([float(each.force_at(speed)) for each in self._alike])[self._kind]
        relieving = np.bincount(self._valve, np.where(self._adds, 0.0, available), self._valves)
        own, of_brakes = (float(demand.sum()), float(relieving.sum())) if self._across else (demand, relieving)
        shares = np.broadcast_to(np.minimum(own / np.maximum(of_brakes, 1e-3), 1.0), self._valves)[self._valve]
        target = available * np.where(self._adds, share[self._first], shares)
        self._lagged = self._lagged - np.expm1(-step / self._time) * (target - self._lagged)
        force = np.minimum(self._lagged, available)
        provided = np.bincount(self._valve, np.where(self._adds, 0.0, force), self._valves)
        lacking = np.maximum(demand - provided, 0.0)
        surplus = max(float(demand.sum() - provided.sum()), 0.0) / max(float(lacking.sum()), 1e-3)
        left = ((surplus if self._across else 1.0) * lacking / np.maximum(demand, 1e-9))[self._valve_of_axle]
        return _friction_force(brakes, speed, left * pads), self._parts @ force, left


def _friction_force(brakes: dict[str, Vector], speed: float | Matrix, pad_force: Vector) -> Vector:
    slower = 1 - speed * brakes["sliding"] / brakes["speed_nominal"]
    friction = brakes["pad_friction"] * (1 + brakes["speed_effect"] * slower)
    friction = friction * (1 - brakes["force_effect"] * (pad_force / brakes["force_nominal"] - 1))
    lever = brakes["lever"] * friction
    if "nominal_shape" in brakes:
        lever = lever * (law_of(brakes).shape(speed * brakes["sliding"], pad_force) / brakes["nominal_shape"])
    return lever * pad_force


def law_of(brakes: dict[str, Vector]) -> BlockLaw:
    """Return the law of blocks with arrays of the data of some units; it is constant for pads."""
    return BlockLaw(factor=1, **{name: cast(Any, brakes[name]) for name in SHAPE})


def wire_of(train: Train, bogie: int) -> tuple[float, float]:
    """Return delay and time constant of the electropneumatic command of a bogie [s]: its own, or those of [command]."""
    command, data = train.command, train.bogies_in_train[bogie].data
    if data.build_up_delay is not None and data.build_up_time is not None:
        return data.build_up_delay, data.build_up_time
    return (command.delay, command.time_constant) if isinstance(command, Electropneumatic) else (0.0, 0.0)


def _build_up_of(train: Train) -> tuple[Vector, Vector, Vector]:
    """Return delay [s], time constant or filling time [s], and inshot of the pressure at each axle."""
    match train.command:
        case None:
            rows = [(0.0, 0.0, 0.0)] * len(train.axles)
        case Electropneumatic():
            rows = [(*wire_of(train, axle.bogie), 0.0) for axle in train.axles]
        case BrakePipe() as pipe:
            speed, filling = _front_speed(train, pipe), train.filling_of_car
            rows = [(axle.position / speed, *filling[axle.car]) for axle in train.axles]
    delay, time, inshot = np.array(rows).T
    return delay, time, inshot


class _PressureBuildUp:
    """Build-up of the brake pressure at each axle through a stop.

    Two-stage distributors have the relays of RailBraking.Pneumatics.TwoStageDistributor.
    """

    def __init__(self, train: Train, speed: float) -> None:
        self._command, parts = train.command, _stages_of(train)
        self._delay, self._time, self._inshot = _build_up_of(train)
        values = [(1.0, 0.0, 1.0) if d is None else (d.low_share, d.speed_down, d.stage_time) for d in parts]
        self._low, self._down, time = np.array(values).T
        # A demand at a speed between the two thresholds starts in the low stage.
        self._stage = np.where([d is None or speed >= d.speed_up for d in parts], 1.0, self._low)
        self._progress = -np.expm1(-_STEP / time)

    def share(self, time: float | Matrix, speed: float | Matrix) -> Vector:
        """Return the pressure at each axle in the next step as a share of the highest, shape (axles,).

        With times of shape (draws, axles) and speeds of shape (draws, 1) it has the shape (draws, axles).
        """
        match self._command:
            case None:
                return np.ones(self._delay.size)
            case Electropneumatic():
                return -np.expm1(-np.maximum(time - self._delay, 0.0) / self._time)
            case BrakePipe():
                after = time - self._delay
                filled = np.clip(self._inshot + (_FILLED - self._inshot) * after / self._time, 0.0, 1.0)
                target = np.where(speed < self._down, self._low, self._stage)
                self._stage = self._stage + self._progress * (target - self._stage)
                return self._stage * np.where(after > 0, filled, 0.0)


def _stages_of(train: Train) -> list[Stages | None]:
    """Return the stages of the distributor of each axle; None for a single one."""
    of_car = train.stages_of_car
    return [of_car[axle.car] for axle in train.axles]


_BRAKE = ("piston_area", "rigging", "efficiency", "spring_force", "pressure_max", "pad_friction")
_PAD_EFFECTS = ("speed_effect", "speed_nominal", "force_effect", "force_nominal")
"""Data of pads on which the force of a stop depends; the temperature is nominal."""


def _each(parts: Sequence[Table], name: str) -> Vector:
    return np.array([getattr(part, name) for part in parts])


def _rolling(train: Train, wheel: Vector) -> Vector:
    # Bearing resistance as in RailBraking.Components.bearingFriction.
    friction, radius = train.physics.bearing_friction, train.physics.bearing_radius
    bearing = 1 / np.sqrt(wheel**2 / (friction * radius) ** 2 * (1 + friction**2) - 1)
    return bearing + train.physics.rolling_arm / wheel
