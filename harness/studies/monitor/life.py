"""A simulated life: stops of one train, with what changes from stop to stop and what breaks.

Every stop is a run of the plant FMU `TwoPartTrain`; readings are those of service sensors at 25 Hz.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.scenario.seed import generator
from railgrip.studies.monitor.transducers import PRESSURE_OFFSET
from railgrip.trace.samples import recording_of
from railgrip.twins.plant import defaults, plant

Vector = NDArray[np.float64]

PLANT = "TwoPartTrain"
INPUTS = {"pressure_command": ("Pa", 4), "mu0": ("1", 6), "track_force": "N"}
OUTPUTS = {
    "speed": "m/s",
    "acceleration": "m/s2",
    "wheelset_speed": ("rad/s", 4),
    "cylinder_pressure": ("Pa", 4),
    "pad_friction": ("1", 4),
}
PERIOD = 0.04  # s; the solver of the plant steps finer, and half the readings of 0.02 s widen the evidence by √2
COASTING = 4.0  # s before the brake
_SLOT = 2.0  # s that a group is released for the test
_FIRST_SLOT = 2.5  # s after the brake began
_LAG = 0.2  # s, time constant of the cylinders
_DOPPLER = 0.12  # s between readings of the train speed
_END = 2.0  # m/s


@dataclass(frozen=True, slots=True, kw_only=True)
class Life:
    """What happens to a train; sizes after domain data: lots 10 %, units 5 %, wet pads −20…−30 % at first.

    Attributes:
        stops: How many.
        seed: Of everything that is drawn.
        worn: Stop from which one group has lost friction; None never.
        worn_group: Which, 0 to 3.
        loss: Share of friction that it has lost.
        stuck: Stop from which one group does not release; None never.
        stuck_group: Which.
        residual: Pressure that the stuck group keeps [Pa].
        testing: Groups are released in turn, so that they can be told apart.
        pressure_offset: 1σ of what each pressure transducer is off for the whole life [Pa], beside 500 Pa that are new
            in every stop.
    """

    stops: int
    seed: int
    worn: int | None = None
    worn_group: int = 0
    loss: float = 0.20
    stuck: int | None = None
    stuck_group: int = 2
    residual: float = 0.8e5
    testing: bool = True
    pressure_offset: float = PRESSURE_OFFSET


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatedStop:
    """One stop of a life.

    Attributes:
        recording: What was read, with the truth of pad friction.
        temperature: Of the discs at the start as read [K], shape (4,).
    """

    recording: xarray.Dataset
    temperature: Vector


def live(life: Life, numbers: range | None = None) -> Iterator[SimulatedStop]:
    """Yield the stops of a life in order; `numbers` takes some of them, each the same as in the whole."""
    lot = generator(life.seed, "life.lot")
    base = 1.0 + 0.05 * lot.standard_normal(4)
    transducers = life.pressure_offset * generator(life.seed, "life.transducers").standard_normal(4)
    wear = lot.uniform(0.0, 0.04, 4)  # share of friction lost over the life by glazing; still healthy
    for k in numbers or range(life.stops):
        random = generator(life.seed, f"life.stop.{k}")
        factor = base * (1.0 - wear * k / max(life.stops - 1, 1)) * (1.0 + 0.02 * random.standard_normal(4))
        wet = random.random() < 0.2
        factor *= 1.0 - (random.uniform(0.0, 0.05) if wet else 0.0)
        begins = factor * (random.uniform(0.70, 0.80) if wet else 1.0)
        if life.worn is not None and k >= life.worn:
            factor[life.worn_group] *= 1.0 - life.loss
            begins[life.worn_group] *= 1.0 - life.loss
        stuck = life.stuck_group if life.stuck is not None and k >= life.stuck else None
        yield _stop(life, k, random, 0.35 * factor, 0.35 * begins, stuck, transducers)


def testing_pressure(time: float, full: Vector, testing: bool) -> Vector:
    """Return the pressures that are demanded at a time since the beginning of the recording [Pa], shape (4,)."""
    if time < COASTING:
        return np.zeros(4)
    demand = full.copy()
    slot = int((time - COASTING - _FIRST_SLOT) // _SLOT)
    if testing and 0 <= slot < 4:
        demand[slot] = 0.0
    return demand


def _stop(
    life: Life,
    number: int,
    random: np.random.Generator,
    friction: Vector,
    begins: Vector,
    stuck: int | None,
    transducers: Vector,
) -> SimulatedStop:
    nominal = defaults(PLANT)
    full = random.uniform(0.6, 0.9) * np.array([nominal[f"p_max[{g + 1}]"] for g in range(4)])
    speed = random.uniform(70.0, 110.0) / 3.6
    load = 1.0 + 0.05 * random.standard_normal()  # passengers; the monitor believes in the nominal mass
    slope = 0.002 * random.standard_normal()
    discs = random.uniform(293.15, 393.15, 4)
    parameters = {"speed_start": speed, "T_pressure": _LAG, "k_A": 1.0, "k_S": 0.4, "A_falling": 0.4, "B_falling": 0.6}
    mass = 0.0
    for i in range(6):
        parameters[f"m_wheelset[{i + 1}]"] = load * nominal[f"m_wheelset[{i + 1}]"]
        mass += parameters[f"m_wheelset[{i + 1}]"]
    for g in range(4):
        parameters[f"mu_b_nominal[{g + 1}]"] = float(friction[g])
        parameters[f"mu_b_start[{g + 1}]"] = float(begins[g])
        parameters[f"T_disc_start[{g + 1}]"] = float(discs[g])
    force = -mass * 9.81 * slope
    inputs = np.concatenate([np.zeros(4), np.full(6, 0.4), [force]])
    rows: list[Vector] = []
    told: list[Vector] = []
    shown = np.zeros(4)
    with plant(PLANT, inputs=INPUTS, outputs=OUTPUTS, period=PERIOD, parameters=parameters) as train:
        if stuck is not None:
            inputs[stuck] = life.residual
        rows.append(train.start(inputs))
        told.append(shown.copy())
        while rows[-1][0] > _END and len(rows) * PERIOD < 90.0:
            demand = testing_pressure((len(rows) - 1) * PERIOD, full, life.testing)
            inputs[:4] = demand
            if stuck is not None:
                inputs[stuck] = max(demand[stuck], life.residual)
            rows.append(train.step(inputs))
            shown = demand + (shown - demand) * np.exp(-PERIOD / _LAG)
            truth = rows[-1][6:10].copy()
            if stuck is not None:
                truth[stuck] = shown[stuck]  # the valve's pressure; the rigging behind it is what sticks
            told.append(truth)
    truth = np.array(rows)
    count = len(truth)
    noise = random.standard_normal
    velocity = truth[:, 0] * (1.0 + 0.003 * noise()) + 0.1 * noise(count)
    velocity[np.arange(count) % round(_DOPPLER / PERIOD) != 0] = np.nan
    acceleration = truth[:, 1] + 9.81 * slope + 0.05 * noise() + 0.03 * noise(count)
    wheels = truth[:, 2:6] + 0.2 * noise((count, 4))
    pressure = np.array(told) + transducers + 500.0 * noise(4)
    signals: dict[str, tuple[Vector, str]] = {"speed": (velocity, "m/s"), "acceleration": (acceleration, "m/s2")}
    for g in range(4):
        signals[f"wheelset_speed[{g + 1}]"] = (wheels[:, g], "rad/s")
        signals[f"cylinder_pressure[{g + 1}]"] = (np.maximum(pressure[:, g], 0.0), "Pa")
    known = {f"mu_b[{g + 1}]": (truth[:, 10 + g], "1") for g in range(4)}
    recording = recording_of(signals, period=PERIOD, truth=known, name=f"stop-{number:04d}")
    return SimulatedStop(recording=recording, temperature=discs + 10.0 * noise(4))
