"""Dry emergency stops of trains, and the time to build and to step a train."""

import os
import re
from dataclasses import dataclass
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

import railgrip.scenario
from railgrip.base.errors import ScenarioError
from railgrip.base.files import scratch
from railgrip.estimators.belief import Vector
from railgrip.fmus.build import build_class
from railgrip.rolling_stock.modelica import class_name, class_text
from railgrip.rolling_stock.schema import BrakePipe, Train, load_train
from railgrip.rolling_stock.stopping import HandCalculation, by_hand, chain_forces
from railgrip.scenario.file import merge
from railgrip.scenario.load import read_toml, scenario_of
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.schema import Scenario
from railgrip.simulate.assembly import StopAssembly, assemble
from railgrip.simulate.loop.loop import Ending
from railgrip.simulate.named_models import plant_description
from railgrip.studies.bench.fmi import plant_step

LIBRARY = Path(__file__).parent / "library"
EQUIPMENT = Path(railgrip.scenario.__file__).parent / "equipment"
USUAL_SPEED = 120 / 3.6  # m/s, where a train file names none
_STEPS, _ROUNDS = 2000, 3
_FULL_BRAKE = {"pressure_command": 1e7, "mu0": 0.5}
_FIRST_SHARE = 0.05  # of the highest pressure, at which a cylinder has begun to fill
_FULL_SHARE = 0.95  # UIC 540, as the two below

FILLING, PROPAGATION = (3.0, 5.0), 250.0
"""Seconds to 95 % in position P; slowest front of an emergency brake [m/s]."""


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


@dataclass(frozen=True, slots=True, kw_only=True)
class DryStop:
    """A dry emergency stop of a train, and its calculation by hand.

    Attributes:
        states: Number of states of the FMU.
        build_s: CPU time from Modelica to FMU, without a cache [s].
        plant_step_us: CPU time of a communication step of 1 ms of the plant in C, with full brake [µs].
        cycle_us: CPU time of a cycle of the loop, including sensors and controller [µs].
        coupler_force: Maximum force in each coupler, compression positive, shape (couplers,) [N].
        chain: Maximum force in a chain of masses and springs under the forces of the calculation by hand, shape
            (couplers,) [N].
    """

    train: Train
    speed: float
    distance: float
    hand: HandCalculation
    states: int
    build_s: float
    plant_step_us: float
    cycle_us: float
    coupler_force: Vector
    chain: Vector
    filling: Filling | None


def dry_scenario(train: str | Path, speed: float) -> Scenario:
    """Return the dry emergency stop of a named train or a train file."""
    table = merge(read_toml(LIBRARY / "dry.toml"), {"vehicle": {"train": str(train)}, "start": {"speed": speed}})
    return scenario_of(table, directory=Path(), origin="dry.toml")


def dry_stop(train: str | Path) -> DryStop:
    """Build a train if need be, by its name or file; stop it from the speed of its first published stop, and time it.

    Raises:
        ScenarioError: The train does not stop.
    """
    data = load_train(Path(train))
    from_speed = data.reference[0].speed if data.reference else USUAL_SPEED
    scenario = dry_scenario(train, from_speed)
    seconds, result, parts = _measure_time(scenario, f"{data.name}: the dry stop")
    trace = parts.recorder.trace(result.samples, scenario.periods.communication)
    force = trace["coupler_force"].values if "coupler_force" in trace else np.zeros((1, 0))
    push, pull = (-force).max(axis=0, initial=0.0), force.max(axis=0, initial=0.0)
    hand, plant = by_hand(data, from_speed), plant_description(scenario)
    return DryStop(
        train=data,
        speed=from_speed,
        distance=float(trace["distance"].values[-1]),
        hand=hand,
        states=len(plant.states),
        build_s=_build_seconds(data),
        plant_step_us=plant_step(plant, _FULL_BRAKE, count=_STEPS, rounds=_ROUNDS),
        cycle_us=1e6 * seconds / result.samples,
        coupler_force=np.maximum(push, pull),
        chain=chain_forces(data, hand),
        filling=filling_of(data, trace) if isinstance(data.command, BrakePipe) else None,
    )


def _build_seconds(train: Train) -> float:
    with scratch("study") as folder:
        # A new title, which is part of the cache's key.
        text = class_text(train.model_copy(update={"description": str(folder)}), pneumatic=False)
        name = class_name(train, pneumatic=False)
        source = folder / f"{name}.mo"
        source.write_text(text, encoding="utf-8")
        # The C compiler is a child.
        begin = sum(os.times()[:4])
        build_class(name, source)
        return sum(os.times()[:4]) - begin


def protected_stop(estimator_period: float) -> dict[str, float]:
    """Stop the four-car train on a poor rail as `library/protected.toml` has it, with valves, sensors and estimator.

    Returns:
        As trains.json has it: period of the estimator [s], length of the stop [s], time of the processor [s], the best
        of some runs, and simulated time over that of the processor.

    Raises:
        ScenarioError: The train does not stop.
    """
    service = read_toml(EQUIPMENT / "service.toml")
    del service["vehicle"]
    table = merge(merge(read_toml(LIBRARY / "dry.toml"), service), read_toml(LIBRARY / "protected.toml"))
    table["periods"]["estimator"] = estimator_period
    scenario = scenario_of(table, directory=Path(), origin="protected.toml")
    runs = [_measure_time(scenario, f"{scenario.name}: the protected stop") for _ in range(_ROUNDS)]
    simulated, processor = runs[-1][1].samples * scenario.periods.communication, min(seconds for seconds, *_ in runs)
    return {
        "estimator_period_s": estimator_period,
        "simulated_s": simulated,
        "processor_s": processor,
        "times_real_time": simulated / processor,
    }


def _measure_time(scenario: Scenario, subject: str) -> tuple[float, Ending, StopAssembly]:
    with assemble(scenario) as parts:
        begin = process_time()
        result = parts.run()
        seconds = process_time() - begin
    if result.outcome is not Outcome.STANDSTILL:
        raise ScenarioError(f"{subject} ended with {result.outcome.value}: {result.reason}")
    return seconds, result, parts


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


def repeat_cars(text: str, cars: int) -> str:
    """Return the text of a train file with a number of cars like the second one of another file."""
    head, _, second, *_ = text.split("[[cars]]")
    second = second.split("[[")[0]
    name = re.search(r'^name = "(.*)"$', head, re.MULTILINE)
    assert name is not None  # or the file has been refused
    head = head.replace(name[0], f'name = "{name[1]}_{cars}"', 1)
    rows = [
        re.sub(r'^name = ".*"$', f'name = "C{number}"', second, flags=re.MULTILINE) for number in range(1, cars + 1)
    ]
    rows[-1] = re.sub(r"^coupler = .*\n", "", rows[-1], flags=re.MULTILINE)
    return head + "".join("[[cars]]" + row for row in rows)
