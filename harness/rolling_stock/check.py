"""Checks of a train for contradictions and unusual values."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from railgrip.base.errors import InputError
from railgrip.base.groups import gather
from railgrip.rolling_stock.calculation import PARKING_ADHESION, PARKING_SLOPE, parking
from railgrip.rolling_stock.schema import BogieInTrain, BrakePipe, Train, load_train
from railgrip.rolling_stock.stopping import HandCalculation, by_hand
from railgrip.scenario.quantity import unusual
from railgrip.vehicle.brake import LOWEST_PAD_FRICTION, lowest_friction

_SAME_MASS = 0.01  # relative difference between car mass and axle loads, from rounding in data sheets
_DESIGN_ADHESION = 0.15  # LOC&PAS TSI (EU 1302/2014), 4.2.4.6.1: maximum adhesion in design, 30 to 250 km/h
_CLOSE = 0.10  # relative difference to a published distance
_SENSED = 1e4  # Pa; with less, the finite cells speed up the front by 6 % or more, see Pneumatics.Accelerator
_ROTATING = (0.01, 0.30)  # rotating over total mass; 5 % to 10 % for coaches, up to 25 % for locomotives (EN 14531-1)
_HIGHEST_ADHESION = 0.6  # dry rail carries up to 0.5 (Polach, 2005)
_DRAG_OF_ENDS, _DRAG_OF_CAR = 1.5, 0.6  # coefficient; trains have 0.3 to 1, and 0.1 to 0.4 for each car (Peters, 1983)
_FAR = 4  # times the usual maximum
_PISTON_FORCE = 1e5  # N; a piston of 16 in presses with 65 kN at 5 bar
_AIR_PRESSURE = 1.05e6  # Pa; supply of the main reservoir, EN 14198
_PIPE_PRESSURE = 5e5  # Pa; of a released brake pipe, and of auxiliary reservoirs (UIC 540)
_CYLINDER = 3e-3  # m3; of cylinder and hose of a unit, V_cylinder of RailBraking.Vehicles.PartialTrain
_TREAD = 0.95  # of the wheel radius; units for wheels of two sizes are described once
_BLOCK_FORCE = 4e4  # N; wagons have 10 to 30 kN, and Open Rails (TrainCar.cs) warns from 20 kN
_OIL_PISTON = 5e-3  # m2; pistons of hydraulic calipers are smaller than 80 mm
USUAL_SPEED = 120 / 3.6  # m/s, where the file has no reference stop


@dataclass(frozen=True, slots=True)
class TrainRemark:
    """A finding of the check of a train.

    Attributes:
        key: Key in the train file.
        sentence: Finding, and where to look for its cause.
        wrong: Whether it is a contradiction; otherwise it is an unusual value.
    """

    key: str
    sentence: str
    wrong: bool = True

    def __str__(self) -> str:
        return f"{self.key}: {self.sentence}"


def checked_train(path: Path) -> Train:
    """Return the train of a file without contradictions.

    Raises:
        InputError: The file cannot be read, is not a train, or contradicts itself; one line per problem.
    """
    train = load_train(path)
    wrong = [f"{path.name}: {result}" for result in findings(train) if result.wrong]
    if wrong:
        raise InputError("\n".join(wrong))
    return train


def findings(train: Train) -> list[TrainRemark]:
    """Return all inconsistent or unusual values, errors first."""
    once = train.model_copy(update={"cars": train.entries})  # equal cars are one entry, as in the file
    results = [
        *(TrainRemark(key, words, wrong=False) for key, words in unusual(once)),
        *_masses(train),
        *_resistance(train),
        *_places(train),
        *_brakes(train),
        *friction_findings(train, fastest_stop(train)),
        *_accelerators(train),
        *_reservoirs(train),
        *_parking(train),
        *_dynamic(train),
    ]
    if not any(finding.wrong for finding in results):
        results += _stops(train)
    return sorted(results, key=lambda result: not result.wrong)


def fastest_stop(train: Train) -> float:
    """Return the highest speed of [[reference]], or `USUAL_SPEED` without any [m/s]."""
    return max((reference.speed for reference in train.reference), default=USUAL_SPEED)


def friction_findings(train: Train, speed: float) -> list[TrainRemark]:
    """Return the pads whose linear law of friction does not hold in a stop from a speed [m/s]."""
    remarks: dict[str, TrainRemark] = {}
    for bogie in train.bogies_in_train:
        brake, sliding = bogie.brake, bogie.brake.friction_radius / bogie.data.wheel_radius
        law, pads = bogie.law, bogie.pads
        nominal = bogie.pad_friction / law.shape(pads.speed_nominal, pads.force_nominal)
        friction, at_speed, at_force = lowest_friction(
            nominal, effects=pads.model_dump(), speed=speed * sliding, force=brake.full_force, shape=law.shape
        )
        if friction > LOWEST_PAD_FRICTION:
            continue
        if brake.blocks is not None:
            key = f"[blocks.{brake.blocks}] law"
            force = f"{at_force / 1e3 / (brake.block_count or 1):.3g} kN on a block"
            law_holds = "the law is used"
            remedy = "Reduce the force of [brakes] or the speed, or give more blocks"
        else:
            key = f"[pads.{brake.pads}] speed_effect, force_effect"
            force = f"{at_force / 1e3:.3g} kN of pad force"
            law_holds = "the linear law holds"
            remedy = "Reduce the effects, or give the mean friction of the stop and no effects"
        words = f"friction falls to {friction:.3f} at {3.6 * at_speed / sliding:g} km/h and {force} in a stop from "
        words += f"{3.6 * speed:g} km/h; {law_holds} only where friction is above {LOWEST_PAD_FRICTION:g}. {remedy}"
        remarks.setdefault(key, TrainRemark(key, words))
    return list(remarks.values())


def usual_speeds(train: Train) -> list[float]:
    """Return the speeds of [[reference]], ascending, or `USUAL_SPEED` without any [m/s]."""
    return sorted({reference.speed for reference in train.reference} or {USUAL_SPEED})


def stops_by_hand(train: Train) -> dict[float, HandCalculation]:
    """Return speed [m/s] → stop for the usual speeds of a train."""
    return {speed: by_hand(train, speed) for speed in usual_speeds(train)}


def _resistance(train: Train) -> Iterator[TrainRemark]:
    if train.resistance is None:
        return
    drag, usual = train.resistance.drag_coefficient, _DRAG_OF_ENDS + _DRAG_OF_CAR * (len(train.cars) - 1)
    if drag > usual:
        yield TrainRemark(
            "[resistance] drag_coefficient",
            f"is {drag:g}; a train of {len(train.cars)} cars has up to {usual:g}: some 0.3 to 1 for its ends and 0.1 "
            "to 0.4 for each car (Peters, 1983)",
            wrong=drag > _FAR * usual,
        )


def _masses(train: Train) -> Iterator[TrainRemark]:
    shared = any(mount.shared for car in train.cars for mount in car.bogies)
    if shared:
        pairs = [("[[cars]] mass", "all cars together", sum(car.mass for car in train.cars), train.mass)]
    else:
        load = [sum(axle.mass for axle in train.axles if axle.car == i) for i in range(len(train.cars))]
        of_entry = {
            f"[cars[{car.entry}]] mass": (car, on_axles) for car, on_axles in zip(train.cars, load, strict=True)
        }
        pairs = [(key, car.name, car.mass, on_axles) for key, (car, on_axles) in of_entry.items()]
    for key, who, mass, on_axles in pairs:
        if abs(mass - on_axles) > _SAME_MASS * mass:
            yield TrainRemark(
                key,
                f"mass of {who} is {mass / 1e3:g} t, but the axles carry {on_axles / 1e3:g} t; "
                "correct mass or axle_masses",
            )
    for kind, ours in _by_kind(train):
        for bogie in ours:
            unsprung = bogie.data.frame_mass + bogie.data.axle_mass * len(bogie.axles)
            load = sum(train.axles[i].mass for i in bogie.axles)
            if unsprung >= load:
                yield TrainRemark(
                    f"[bogies.{kind}] frame_mass",
                    f"frame and axles have a mass of {unsprung / 1e3:g} t, but the bogie's axles carry only "
                    f"{load / 1e3:g} t",
                )
                break
    rotating = (
        sum(axle.inertia / train.bogies_in_train[axle.bogie].data.wheel_radius ** 2 for axle in train.axles)
        / train.mass
    )
    low, high = _ROTATING
    if not low <= rotating <= high:
        yield TrainRemark(
            "[bogies] inertia",
            f"rotating parts add {100 * rotating:.1f} % to the mass; {100 * low:.0f} % to {100 * high:.0f} % are usual",
            wrong=not low / _FAR <= rotating <= _FAR * high,
        )


def _places(train: Train) -> Iterator[TrainRemark]:
    for number, car in enumerate(train.entries, start=1):
        for mount in car.bogies:
            half = train.bogies[mount.kind].wheelbase / 2
            if not mount.shared and (mount.at < half or mount.at + half > car.length):
                yield TrainRemark(
                    f"[cars[{number}]] bogies",
                    f"the axles of {mount.kind} at {mount.at:g} m are not under {car.name}, {car.length:g} m long",
                )
    for kind, bogie in train.bogies.items():
        gaps = [b - a for a, b in zip(bogie.axles, bogie.axles[1:], strict=False)]
        if gaps and min(gaps) <= 2 * bogie.wheel_radius:
            yield TrainRemark(
                f"[bogies.{kind}] axles",
                f"wheels with a diameter of {2e3 * bogie.wheel_radius:g} mm touch where axles are "
                f"{1e3 * min(gaps):g} mm apart",
            )


def _brakes(train: Train) -> Iterator[TrainRemark]:
    for kind, brake in train.brakes.items():
        if brake.spring_force >= brake.pressure_max * brake.piston_area:
            yield TrainRemark(
                f"[brakes.{kind}] spring_force",
                f"the spring holds the piston back at pressure_max: {brake.spring_force:g} N against "
                f"{brake.pressure_max * brake.piston_area:g} N",
            )
        piston = brake.pressure_max * brake.piston_area
        is_oil = brake.pressure_max > _AIR_PRESSURE
        if piston > _PISTON_FORCE or (is_oil and brake.piston_area > _OIL_PISTON):
            yield TrainRemark(
                f"[brakes.{kind}] pressure_max",
                f"is {brake.pressure_max / 1e5:g} bar on {1e4 * brake.piston_area:g} cm2, {piston / 1e3:.0f} kN at the "
                "piston; cylinders have up to 10 bar of air, or oil on pistons of less than 50 cm2",
                wrong=piston > _PISTON_FORCE,
            )
        wheels = [bogie.wheel_radius for bogie in train.bogies.values() if bogie.brake == kind]
        if wheels and brake.friction_radius > 1.001 * min(wheels):
            yield TrainRemark(
                f"[brakes.{kind}] friction_radius",
                f"is {brake.friction_radius:g} m, beyond the wheel, whose radius is {min(wheels):g} m",
            )
        elif brake.blocks and wheels and brake.friction_radius < _TREAD * max(wheels):
            yield TrainRemark(
                f"[brakes.{kind}] friction_radius",
                f"is {brake.friction_radius:g} m, but blocks press on the tread of wheels of {max(wheels):g} m",
            )
        if brake.block_count and brake.full_force > _BLOCK_FORCE * brake.block_count:
            yield TrainRemark(
                f"[brakes.{kind}] block_count",
                f"gives {brake.full_force / brake.block_count / 1e3:.0f} kN on a block; usual are 5 to "
                f"{_BLOCK_FORCE / 1e3:g} kN, and the laws of friction hold there",
                wrong=False,
            )


def _accelerators(train: Train) -> Iterator[TrainRemark]:
    for kind, vent in train.accelerators.items():
        drop = vent.opening_rate * vent.sensing_time
        if drop < _SENSED:
            yield TrainRemark(
                f"[accelerators.{kind}] sensing_time",
                f"times opening_rate is {drop / 1e5:g} bar: below {_SENSED / 1e5:g} bar the computed brake front is "
                "faster than sound, because the cells of the pipe smear it",
                wrong=False,
            )


def _reservoirs(train: Train) -> Iterator[TrainRemark]:
    """Yield cars whose reservoir falls, isothermally, below the pressure of its cylinders in a single application."""
    is_pipe = isinstance(train.command, BrakePipe)
    source = train.command if isinstance(train.command, BrakePipe) else train.air
    if source is None or source.reservoir is None:
        return
    volume = source.reservoir
    start = _PIPE_PRESSURE if train.air is None or is_pipe else train.air.pressure
    for number, car in enumerate(train.cars):
        axles = [(axle.units, train.bogies_in_train[axle.bogie].brake) for axle in train.axles if axle.car == number]
        air = sum(units * _CYLINDER * brake.pressure_max for units, brake in axles)
        needed = max((brake.pressure_max for _, brake in axles), default=0.0)
        if needed >= start:
            yield TrainRemark(
                "[brakes] pressure_max",
                f"of {car.name} is {needed / 1e5:g} bar, but its reservoir has only {start / 1e5:g} bar at the start",
            )
            return
        if start - air / volume < needed:
            yield TrainRemark(
                f"{'[command]' if is_pipe else '[air]'} reservoir",
                f"of {car.name} falls to {max(start - air / volume, 0.0) / 1e5:.2f} bar when its cylinders fill, below "
                f"the {needed / 1e5:g} bar of pressure_max; it needs {1e3 * air / (start - needed):.0f} l",
            )
            return


def _parking(train: Train) -> Iterator[TrainRemark]:
    held = parking(train)
    if train.parking_brakes and held.slope < PARKING_SLOPE:
        yield TrainRemark(
            "[parking_brakes] force",
            f"holds the train on {1e3 * held.slope:.1f} ‰ with an adhesion of up to {PARKING_ADHESION:g}; a unit must "
            f"be held on {1e3 * PARKING_SLOPE:g} ‰ (LOC&PAS TSI 4.2.4.5.5)",
            wrong=False,
        )


def _dynamic(train: Train) -> Iterator[TrainRemark]:
    used = {str(bogie.data.dynamic_brake) for bogie in train.bogies_in_train}
    for kind, brake in train.dynamic_brakes.items():
        where = f"[dynamic_brakes.{kind}]"
        if kind not in used:
            yield TrainRemark(where, "is on no bogie: name it as dynamic_brake in a table of [bogies]", wrong=False)
        for key, words in brake.doubts():
            yield TrainRemark(f"{where} {key}", words, wrong=False)


def _stops(train: Train) -> Iterator[TrainRemark]:
    try:
        stops = stops_by_hand(train)
    except InputError as problem:
        yield TrainRemark("[brakes]", str(problem))
        return
    fastest = stops[max(stops)]
    for kind, bogies in _by_kind(train):
        most = float(np.max(fastest.adhesion[[i for bogie in bogies for i in bogie.axles]]))
        if most > _DESIGN_ADHESION:
            yield TrainRemark(
                f"[bogies.{kind}] brake",
                f"needs an adhesion of {most:.3f} in an emergency stop; the design of a main-line brake may assume "
                f"{_DESIGN_ADHESION:g} (LOC&PAS TSI 4.2.4.6.1)",
                wrong=most > _HIGHEST_ADHESION,
            )
    for kind, coupler in train.couplers.items():
        forces = {
            place: abs(float(fastest.coupler_force[place]))
            for place, car in enumerate(train.cars[:-1])
            if car.coupler == kind
        }
        overloaded = [place for place, force in forces.items() if force > coupler.strength]
        if overloaded:
            worst = max(overloaded, key=lambda place: forces[place])
            others = f"{len(overloaded)} of {len(forces)} such couplers beyond that, and "
            yield TrainRemark(
                f"[couplers.{kind}] strength",
                f"is {coupler.strength / 1e3:g} kN, but braking alone loads {others if len(overloaded) > 1 else ''}"
                f"the coupler behind {train.cars[worst].name} by {forces[worst] / 1e3:.0f} kN",
            )
    slowest = min(stops)
    for kind in {car.distributor: None for car in train.cars if car.distributor}:
        stages = train.distributors[kind].stages
        if stages is not None and slowest < stages.speed_up:
            yield TrainRemark(
                f"[distributors.{kind}] speed_up",
                f"is {3.6 * stages.speed_up:g} km/h: a stop from {3.6 * slowest:g} km/h is in the low stage throughout",
                wrong=False,
            )
    for number, reference in enumerate(train.reference, start=1):
        distance = stops[reference.speed].distance
        off = distance / reference.distance - 1
        what = f"{distance:.1f} m from {3.6 * reference.speed:g} km/h by hand, {reference.distance:g} m"
        if reference.limit and off > 0:
            yield TrainRemark(f"[reference[{number}]] distance", f"{what} are allowed ({reference.source})")
        elif not reference.limit and abs(off) > _CLOSE:
            words = f"{what} published: {100 * off:+.1f} % ({reference.source})"
            yield TrainRemark(f"[reference[{number}]] distance", words, wrong=False)


def _by_kind(train: Train) -> list[tuple[str, list[BogieInTrain]]]:
    return sorted(gather((bogie.kind, bogie) for bogie in train.bogies_in_train).items())
