"""A simulated life: stops of one train, with variations from stop to stop and with faults.

Every stop is a scenario with a [demand] that the loop runs; readings are those of service sensors at 25 Hz.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import accumulate
from pathlib import Path

import numpy as np
import xarray

from railgrip.base.arrays import generator
from railgrip.base.tables import TomlTable
from railgrip.base.units import GRAVITY
from railgrip.estimators.belief import Vector
from railgrip.fmi import describe
from railgrip.fmus.build import fmu
from railgrip.recording.samples import recording_of
from railgrip.scenario.file import merge
from railgrip.scenario.load import read_toml, scenario_of
from railgrip.simulate.run import trace_of
from railgrip.studies.pad_monitor.evidence import PRESSURE_OFFSET, formation

PLANT = "TwoPartTrain"
PERIOD = 0.04  # s; the solver of the plant steps finer, and half the readings of 0.02 s widen the evidence by √2
COASTING = 4.0  # s before the brake
SLOT = 2.0  # s that a group is released for the test
FIRST_SLOT = 2.5  # s after the brake began
LOT_DEVIATION = 0.05  # of pad friction, from group to group
STOP_DEVIATION = 0.02  # of pad friction, from stop to stop
LOAD_DEVIATION = 0.05  # from stop to stop
SCALE_DEVIATION = 0.003  # of the speed reading, from stop to stop
_LAG = 0.2  # s, time constant of the cylinders
_DOPPLER = 0.12  # s between readings of the train speed
_TRAIN = read_toml(Path(__file__).parent / "library" / "life.toml")
"""Scenario that all stops have in common."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Release:
    """A lower pressure of one group for some time.

    Attributes:
        group: Index of the group, from 0.
        start: Time after the brake began [s].
        duration: Duration [s].
        drop: Reduction of the braking pressure [Pa]; infinity for a complete release.
    """

    group: int
    start: float
    duration: float
    drop: float = math.inf


IN_TURN = tuple(Release(group=g, start=FIRST_SLOT + g * SLOT, duration=SLOT) for g in range(formation().groups))
"""Complete release of each group in turn."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Life:
    """Events in the life of a train; typical variations: lots 10 %, units 5 %, wet pads initially −20…−30 %.

    Attributes:
        stops: Number of stops.
        seed: Seed of everything that is drawn.
        worn: Stop from which one group has lost friction; None for never.
        worn_group: Index of that group, from 0.
        loss: Relative loss of friction.
        stuck: Stop from which one group does not release; None for never.
        stuck_group: Index of that group, from 0.
        residual: Pressure that remains in the stuck group [Pa].
        releases: Releases in every stop, by which groups can be distinguished.
        pressure_offset: 1σ of the offset of each pressure transducer for the whole life [Pa], in addition to 500 Pa
            that are drawn in every stop.
        radii: Wheel radius of each group over the nominal one; empty for nominal wheels.
    """

    stops: int
    seed: int
    worn: int | None = None
    worn_group: int = 0
    loss: float = 0.20
    stuck: int | None = None
    stuck_group: int = 2
    residual: float = 0.8e5
    releases: tuple[Release, ...] = IN_TURN
    pressure_offset: float = PRESSURE_OFFSET
    radii: tuple[float, ...] = ()


def first_health(life: Life) -> Vector:
    """Return the friction of each group's pads over the nominal one at the start of a life, shape (groups,)."""
    return 1.0 + LOT_DEVIATION * generator(life.seed, "life.lot").standard_normal(formation().groups)


def live(life: Life, numbers: range | None = None) -> Iterator[tuple[xarray.Dataset, Vector]]:
    """Yield the stops of a life in order; `numbers` selects some of them, each the same as in the whole life.

    A stop is its readings with the true pad friction, and the disc temperatures read at the start, (groups,) [K].
    """
    lot, groups = generator(life.seed, "life.lot"), formation().groups
    base = 1.0 + LOT_DEVIATION * lot.standard_normal(groups)
    transducers = life.pressure_offset * generator(life.seed, "life.transducers").standard_normal(groups)
    wear = lot.uniform(0.0, 0.04, groups)  # share of friction lost over the life by glazing; still healthy
    for k in numbers or range(life.stops):
        random = generator(life.seed, f"life.stop.{k}")
        scatter = 1.0 + STOP_DEVIATION * random.standard_normal(groups)
        factor = base * (1.0 - wear * k / max(life.stops - 1, 1)) * scatter
        wet = random.random() < 0.2
        factor *= 1.0 - (random.uniform(0.0, 0.05) if wet else 0.0)
        first_friction = factor * (random.uniform(0.70, 0.80) if wet else 1.0)
        if life.worn is not None and k >= life.worn:
            factor[life.worn_group] *= 1.0 - life.loss
            first_friction[life.worn_group] *= 1.0 - life.loss
        stuck = life.stuck_group if life.stuck is not None and k >= life.stuck else None
        yield _stop(life, k, random, 0.35 * factor, 0.35 * first_friction, stuck, transducers)


def demand_table(full: Vector, releases: Sequence[Release], residual: Vector) -> TomlTable:
    """Return the table [demand] of a stop: coasting, then braking with releases.

    Args:
        full: Braking pressures, shape (groups,) [Pa].
        releases: Releases of single groups; they may overlap.
        residual: Minimum pressure in the cylinders of each group, independent of the demand, shape (groups,) [Pa].
    """
    changes = sorted({end for release in releases for end in (release.start, release.start + release.duration)})
    courses = [np.zeros(full.size), *(braking_pressures(full, releases, begin) for begin in (0.0, *changes))]
    # From the first sample on that is not before.
    instants = [math.ceil(round((COASTING + end) / PERIOD, 6)) * PERIOD for end in (0.0, *changes)]
    ends = [*({"until": {"time": instant}} for instant in instants), {}]
    pressures = [np.maximum(pressure, residual).tolist() for pressure in courses]
    return {"phases": [{"pressure": pressure} | end for pressure, end in zip(pressures, ends, strict=True)]}


def braking_pressures(full: Vector, releases: Sequence[Release], time: float) -> Vector:
    """Return the demanded pressures at a time after the brake began, shape (groups,) [Pa]."""
    pressures = full.copy()
    for release in releases:
        if release.start <= time < release.start + release.duration:
            pressures[release.group] = max(full[release.group] - release.drop, 0.0)
    return pressures


@cache
def _nominal() -> dict[str, float]:
    parameters = (v for v in describe(fmu(PLANT)).variables.values() if v.causality == "parameter" and v.kind == "Real")
    return {v.name: v.start for v in parameters if v.start_text is not None}


def _stop(
    life: Life,
    number: int,
    random: np.random.Generator,
    friction: Vector,
    first_friction: Vector,
    stuck: int | None,
    transducers: Vector,
) -> tuple[xarray.Dataset, Vector]:
    nominal, groups = _nominal(), formation().groups
    full = random.uniform(0.6, 0.9) * np.array([nominal[f"p_max[{g + 1}]"] for g in range(groups)])
    speed = random.uniform(70.0, 110.0) / 3.6
    load = 1.0 + LOAD_DEVIATION * random.standard_normal()  # passengers; the monitor assumes the nominal mass
    slope = 0.002 * random.standard_normal()
    discs = random.uniform(293.15, 393.15, groups)
    loads = {f"m_wheelset[{i + 1}]": load * nominal[f"m_wheelset[{i + 1}]"] for i in range(formation().wheelsets)}
    parameters = {"T_pressure": _LAG} | loads
    parameters |= {f"r_wheel[{g + 1}]": ratio * nominal[f"r_wheel[{g + 1}]"] for g, ratio in enumerate(life.radii)}
    for g in range(groups):
        parameters[f"mu_b_nominal[{g + 1}]"] = float(friction[g])
        parameters[f"mu_b_start[{g + 1}]"] = float(first_friction[g])
        parameters[f"T_disc_start[{g + 1}]"] = float(discs[g])
    residual = np.zeros(groups)
    if stuck is not None:
        residual[stuck] = life.residual
    changes = {
        "name": f"stop-{number:04d}",
        "vehicle": {"parameters": parameters},
        "start": {"speed": speed},
        "periods": dict.fromkeys(("communication", "estimator", "controller", "trace"), PERIOD),
        "track": {"force": -sum(loads.values()) * GRAVITY * slope},
        "demand": demand_table(full, life.releases, residual),
    }
    trace = trace_of(scenario_of(merge(_TRAIN, changes), directory=Path(), origin="life"))
    count = trace.sizes["time"]
    readings = trace["cylinder_pressure"].values.copy()
    if stuck is not None:  # the reading is the pressure of the valve; the rigging behind it sticks
        demand = trace["driver_demand"].values[1:, stuck]
        demand = np.where(demand == life.residual, 0.0, demand)
        readings[:, stuck] = list(
            accumulate(demand, lambda at, to: to + (at - to) * np.exp(-PERIOD / _LAG), initial=0.0)
        )
    noise = random.standard_normal
    velocity = trace["speed"].values * (1.0 + SCALE_DEVIATION * noise()) + 0.1 * noise(count)
    velocity[np.arange(count) % round(_DOPPLER / PERIOD) != 0] = np.nan
    acceleration = trace["acceleration"].values + GRAVITY * slope + 0.05 * noise() + 0.03 * noise(count)
    wheels = trace["wheelset_speed"].values + 0.2 * noise((count, groups))
    pressure = readings + transducers + 500.0 * noise(groups)
    signals: dict[str, tuple[Vector, str]] = {"speed": (velocity, "m/s"), "acceleration": (acceleration, "m/s2")}
    for g in range(groups):
        signals[f"wheelset_speed[{g + 1}]"] = (wheels[:, g], "rad/s")
        signals[f"cylinder_pressure[{g + 1}]"] = (np.maximum(pressure[:, g], 0.0), "Pa")
    truth: dict[str, tuple[Vector, str]] = {"speed": (trace["speed"].values, "m/s")}
    truth |= {f"pad_friction[{g + 1}]": (trace["pad_friction"].values[:, g], "1") for g in range(groups)}
    recording = recording_of(signals, period=PERIOD, truth=truth, name=f"stop-{number:04d}")
    return recording, discs + 10.0 * noise(groups)
