"""Dry emergency stops of trains, and the trial of sanders.

The density of sand is fitted on one of the trial's five distances. The other four are not a blind prediction: further
assumptions of the trial were chosen with all five known.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import root_scalar

import railgrip as rg
from railgrip.base.arrays import Vector
from railgrip.base.units import to_si
from railgrip.report.baseline import Finding
from railgrip.rolling_stock.schema import BrakePipe, Train, load_train
from railgrip.rolling_stock.stopping import by_hand, chain_forces
from railgrip.scenario.file import merge
from railgrip.scenario.schema import Scenario
from railgrip.simulate.run import braking_distance

_DRY = Path(__file__).with_name("dry_stop.toml")
USUAL_SPEED = 120 / 3.6
"""Initial speed where a train file has no published stop [m/s]."""
_FIRST_SHARE, _FULL_SHARE = 0.05, 0.95
"""Shares of the highest pressure at which a cylinder begins to fill, and is full by UIC 540."""


def dry_scenario(train: str | Path, speed: float) -> rg.Scenario:
    """Return the emergency stop of a named train or a train file from a speed [m/s] on a dry rail."""
    return rg.Scenario.load(_DRY, {"vehicle.train": str(train), "start.speed": speed})


def dry_row(train: str) -> dict[str, Any]:
    """Return the dry emergency stop of a train from the speed of its first published stop.

    Forces in couplers are the largest ones [kN]; they and the values of a brake pipe are missing without any.
    """
    data = load_train(Path(train))
    speed = data.reference[0].speed if data.reference else USUAL_SPEED
    trace, hand = rg.run(dry_scenario(train, speed)).trace, by_hand(data, speed)
    row: dict[str, Any] = {"speed": speed, "simulated": float(trace["distance"].values[-1]), "by hand": hand.distance}
    if "coupler_force" in trace:
        forces = {
            "in a coupler": trace["coupler_force"].values,
            "quasi-static": hand.coupler_force,
            "chain": chain_forces(data, hand),
            "strength": min(coupler.strength for coupler in data.couplers.values()),
        }
        row |= {name: 1e-3 * float(np.abs(force).max()) for name, force in forces.items()}
    if isinstance(data.command, BrakePipe):
        filling = filling_of(data, trace)
        row |= {"filling from": filling.filling.min(), "filling to": filling.filling.max()}
        row |= {"front": filling.propagation, "last car begins": filling.begin[-1]}
    return row


@dataclass(frozen=True, slots=True, kw_only=True)
class Filling:
    """Filling of the cylinders behind a brake pipe.

    Attributes:
        begin: Time from the demand to the first pressure in each car, shape (cars,) [s].
        filling: Time from there to 95 % of the highest pressure, shape (cars,) [s].
        propagation: Speed of the front from the first car to the last [m/s].
    """

    begin: Vector
    filling: Vector
    propagation: float


def filling_of(train: Train, trace: Any) -> Filling:
    """Return the instants at which the cylinders of the first group of each car begin to fill and are full."""
    time, pressure = trace["time"].values, trace["cylinder_pressure"].values
    cars = [train.axles[members[0]].car for members in train.groups]
    first = [cars.index(car) for car in range(len(train.cars))]
    highest = np.array([train.bogie_of(g).brake.pressure_max for g in first])
    begin, full = (
        np.array([time[np.argmax(pressure[:, g] > share * top)] for g, top in zip(first, highest, strict=True)])
        for share in (_FIRST_SHARE, _FULL_SHARE)
    )
    lengths = np.array([car.length for car in train.cars])
    middles = np.cumsum(lengths) - lengths / 2
    # The first 5 % take their share of the filling.
    start = begin - (full - begin) * _FIRST_SHARE / (_FULL_SHARE - _FIRST_SHARE)
    return Filling(
        begin=start, filling=full - start, propagation=float((middles[-1] - middles[0]) / (start[-1] - start[0]))
    )


# The trial RSSB T1107: two Class 387 of four cars, RIDC Melton 2017, brake step 3, sand all the way. Distances: Rail
# Engineer, 12 February 2018.
TRIAL_TRAIN, TRIAL_SPEED, DEMANDED_DECELERATION, UNTREATED = "emu387", to_si("55 mph", "m/s"), 0.9, 0.02
"""Train of the trial, its speed [m/s], demanded deceleration [m/s2], and friction of the untreated rail."""
SAND = {"mu0": 0.2, "left": 0.9}
"""Assumed friction with plenty of sand, and share of the sand that each wheelset leaves."""
_FIXED = {"rate": "2 kg/min", "delay": "1.5 s"}
_VARIABLE = {"rate": "5 kg/min", "density": "7.5 g/m", "delay": "1.5 s"}
SANDERS: Mapping[str, tuple[float, list[dict[str, Any]]]] = {
    "none": (1200.0, []),  # or longer
    "one fixed": (800.0, [{"wheelset": 3, **_FIXED}]),
    "two fixed": (650.0, [{"wheelset": 3, **_FIXED}, {"wheelset": 7, **_FIXED}]),
    "one variable": (600.0, [{"wheelset": 3, **_VARIABLE}]),
    "two variable": (400.0, [{"wheelset": 3, **_VARIABLE}, {"wheelset": 7, **_VARIABLE}]),
}
"""Sanders → measured distance [m], and their tables in a scenario."""
_DENSITIES, _CLOSE = (2e-3, 60e-3), 0.005  # kg/m; relative: some metres
_HORIZON = 200.0  # s


def demand() -> list[float]:
    """Return the pressure of each group with the demanded deceleration of the trial [Pa]."""
    train = load_train(Path(TRIAL_TRAIN))
    # Pad force, and with it the deceleration, is even in the pressure beyond that of the spring.
    share = min(DEMANDED_DECELERATION / by_hand(train, TRIAL_SPEED).deceleration, 1.0)
    brakes = [train.bogie_of(group).brake for group in range(len(train.groups))]
    springs = [brake.spring_force / brake.piston_area for brake in brakes]
    return [spring + share * (brake.pressure_max - spring) for brake, spring in zip(brakes, springs, strict=True)]


def trial_stop(sanders: str, density: float) -> Scenario:
    """Return the stop of the trial with some sanders, a key of `SANDERS`, and a density of sand [kg/m]."""
    tables: dict[str, Any] = {
        "name": "sanders",
        "adhesion": {"polach": "wet", "mu0": UNTREATED},
        "controller": {"kind": "slip_three_state"},
        "demand": {"phases": [{"pressure": demand()}]},
        "limits": {"horizon": _HORIZON},
    }
    if laid := SANDERS[sanders][1]:
        tables = merge(tables, {"adhesion": {"sand": SAND | {"density": density}}, "sanders": laid})
    return dry_scenario(TRIAL_TRAIN, TRIAL_SPEED).revised(tables)


def sander_rows(fitted: str) -> list[dict[str, Any]]:
    """Return all distances of the trial, with the density of sand [kg/m] that is fitted to one of them."""

    def excess(density: float) -> float:
        distance = braking_distance(trial_stop(fitted, density))
        return (TRIAL_SPEED * _HORIZON if distance is None else distance) - SANDERS[fitted][0]

    density = float(root_scalar(excess, bracket=_DENSITIES, rtol=_CLOSE).root)
    return [
        {
            "sanders": name,
            "measured": measured,
            "simulated": braking_distance(trial_stop(name, density)),
            "density": density,
        }
        for name, (measured, _) in SANDERS.items()
    ]


def headlines() -> list[Finding]:
    """Return dry distances of named trains, and two distances of the trial of sanders, for the regression."""
    # Nothing slides in a dry stop: only the solver's steps differ on another machine. Under slip control,
    # parameters moved by 1e-7 move a distance by 2e-4.
    speeds = {"vt642": 85 / 3.6, "emu387": 120 / 3.6, "tram": 50 / 3.6}
    stops = {f"trains, {name}: dry distance": (dry_scenario(name, speed), 1e-4) for name, speed in speeds.items()}
    density = 5.4e-3  # kg/m, as fitted
    for name in ("two fixed", "two variable"):
        stops[f"trains, sanders {name}: distance"] = trial_stop(name, density), 2e-3
    found = {name: (braking_distance(scenario) or 0.0, relative) for name, (scenario, relative) in stops.items()}
    return [Finding(name, distance, "m", relative * distance) for name, (distance, relative) in found.items()]
