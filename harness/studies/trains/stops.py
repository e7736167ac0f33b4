"""Stops of trains: dry emergency stops with the time to build and to step a train, and the trial of sanders.

The density of sand is fitted on one of the trial's five distances. The other four are not a blind prediction: further
assumptions of the trial were chosen with all five known.
"""

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from time import process_time
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, StrictBool, model_validator
from scipy.optimize import root_scalar

import railgrip.scenario
from railgrip.base.errors import ScenarioError
from railgrip.base.files import scratch
from railgrip.estimators.belief import Vector
from railgrip.fmus.build import build_class
from railgrip.rolling_stock.modelica import class_name, class_text
from railgrip.rolling_stock.schema import BrakePipe, Train, load_train
from railgrip.rolling_stock.stopping import HandCalculation, by_hand, chain_forces
from railgrip.scenario.file import merge
from railgrip.scenario.load import read_toml, scenario_of, validate_table
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import Friction, Speed, Table, table_error
from railgrip.simulate.assembly import StopAssembly, assemble
from railgrip.simulate.loop.loop import Ending
from railgrip.simulate.named_models import plant_description
from railgrip.simulate.run import braking_distance
from railgrip.studies.bench import plant_step

LIBRARY = Path(__file__).parent / "library"
EQUIPMENT = Path(railgrip.scenario.__file__).parent / "equipment"
USUAL_SPEED = 120 / 3.6  # m/s, where a train file names none
_STEPS, _ROUNDS = 2000, 3
FULL_BRAKE = {"pressure_command": 1e7, "mu0": 0.5}
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
        plant_step_us=plant_step(plant, FULL_BRAKE, count=_STEPS, rounds=_ROUNDS),
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
    return head + "[[cars]]" + re.sub(r"^(name = .*)$", rf"\1\ncount = {cars}", second, count=1, flags=re.MULTILINE)


_FRICTION = 0.02  # of the untreated rail in the trial
_HORIZON = 200.0  # s
_CLOSE = 0.005  # of the density, relative: some metres

Metres = Annotated[float, UnitRange("m", above=0, at_most=1e5)]
Density = Annotated[float, UnitRange("kg/m", above=0, at_most=1)]


class SanderDistance(Table):
    """One of the distances of a trial."""

    sanders: str
    measured: Metres
    at_least: StrictBool = Field(default=False, description="whether the trial only states that it was longer")
    laid: tuple[dict[str, Any], ...]


class SandLaw(Table):
    """Assumptions on sand, and bounds of the search for its density."""

    mu0: Friction
    left: Annotated[float, UnitRange("1", at_least=0, at_most=1)]
    density: tuple[Density, Density]


class SanderTrial(Table):
    """A trial of sanders, `library/sanders.toml`."""

    speed: Speed
    demanded: Annotated[float, UnitRange("m/s2", above=0, at_most=5)]
    train: str
    fitted: str
    source: str
    law: SandLaw
    rows: tuple[SanderDistance, ...]

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.fitted not in {row.sanders for row in self.rows}:
            raise table_error(f"fitted is '{self.fitted}', which no row is called")
        return self


SanderComparison = Mapping[str, Any]
"""A distance of the trial and the simulated one, as in sanders.json: `sanders`; `distance_m`, None for a train that did
not stop within the horizon; `measured_m`; `fitted`, whether the density of sand was fitted to it; `at_least`, true
where the trial gives only a bound."""


def trial_of() -> SanderTrial:
    """Return the trial to compare with."""
    path = LIBRARY / "sanders.toml"
    return validate_table(SanderTrial, read_toml(path), directory=path.parent, origin=path.name)


def scenario_tables(trial: SanderTrial) -> dict[str, Any]:
    """Return the tables that all stops of a trial have in common: its train, demand, rail and protection."""
    train = load_train(Path(trial.train))
    # Pad force, and with it the deceleration, is even in the pressure beyond that of the spring.
    share = min(trial.demanded / by_hand(train, trial.speed).deceleration, 1.0)
    brakes = [train.bogie_of(group).brake for group in range(len(train.groups))]
    springs = [brake.spring_force / brake.piston_area for brake in brakes]
    pressure = [spring + share * (brake.pressure_max - spring) for brake, spring in zip(brakes, springs, strict=True)]
    return merge(
        read_toml(LIBRARY / "dry.toml"),
        {
            "name": "sanders",
            "vehicle": {"train": trial.train},
            "start": {"speed": trial.speed},
            "adhesion": {"polach": "wet", "mu0": _FRICTION},
            "controller": {"kind": "slip_three_state"},
            "demand": {"phases": [{"pressure": pressure}]},
            "limits": {"horizon": _HORIZON},
        },
    )


def scenario_of_row(trial: SanderTrial, row: SanderDistance, density: float, tables: dict[str, Any]) -> Scenario:
    """Return the stop of a row with a density of sand."""
    changes: dict[str, Any] = {}
    if row.laid:
        law = {"mu0": trial.law.mu0, "left": trial.law.left, "density": density}
        changes = {"adhesion": {"sand": law}, "sanders": [dict(sander) for sander in row.laid]}
    return scenario_of(merge(tables, changes), directory=LIBRARY, origin="sanders.toml")


def compare(trial: SanderTrial) -> tuple[float, list[SanderComparison]]:
    """Fit the density of sand on one distance; return it [kg/m] and all distances."""
    tables = scenario_tables(trial)
    fitted = next(row for row in trial.rows if row.sanders == trial.fitted)

    def excess(density: float) -> float:
        distance = braking_distance(scenario_of_row(trial, fitted, density, tables))
        return (trial.speed * _HORIZON if distance is None else distance) - fitted.measured

    density = float(root_scalar(excess, bracket=trial.law.density, rtol=_CLOSE).root)
    return density, [
        {
            "sanders": row.sanders,
            "distance_m": braking_distance(scenario_of_row(trial, row, density, tables)),
            "measured_m": row.measured,
            "fitted": row is fitted,
        }
        | ({"at_least": True} if row.at_least else {})
        for row in trial.rows
    ]
