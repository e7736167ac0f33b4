"""The generic wagon of two braked wheelsets on a rail: scenario → recording."""

import math
from pathlib import Path
from typing import Annotated, Self

import numpy as np
import xarray
from numpy.typing import NDArray
from pydantic import Field, model_validator

from railgrip.scenario.quantity import Unit
from railgrip.scenario.seed import generator
from railgrip.scenario.table import Duration, Friction, Name, Parameters, Seed, Speed, Table
from railgrip.trace.samples import recording_of
from railgrip.twins.load import Pressure, Time, in_order, load_twin
from railgrip.twins.plant import parameters, plant

Vector = NDArray[np.float64]

PLANT = "Wagon"
INPUTS = {"pressure_command": ("Pa", 2), "mu0": ("1", 2), "track_force": "N"}
OUTPUTS = {
    "wheelset_speed": ("rad/s", 2),
    "speed": "m/s",
    "pad_force": ("N", 2),
    "adhesion": ("1", 2),
    "wheelset_load": ("N", 2),
    "pad_friction": ("1", 2),
    "resistance_torque": ("N.m", 2),
}


class WagonSensors(Table):
    """[sensors]: standard deviation of each reading; white from sample to sample."""

    wheelset_speed: Annotated[float, Unit("rad/s", at_least=0)]
    speed: Annotated[float, Unit("m/s", at_least=0)]
    pad_force: Annotated[float, Unit("N", at_least=0)]


class WagonScenario(Table):
    """Everything that decides a run of the wagon; `demand` in steps, `mu0` straight between its points."""

    name: Name
    description: str = ""
    seed: Seed
    speed_start: Speed
    stop_speed: Speed
    horizon: Duration
    period: Duration
    demand: list[tuple[Time, Pressure, Pressure]]
    mu0: list[tuple[Time, Friction]]
    track_force: Annotated[float, Unit("N")]
    sensors: WagonSensors
    parameters: Parameters = Field(default_factory=dict)

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        in_order("demand", self.demand)
        in_order("mu0", self.mu0)
        return self


def wagon_scenario(name: str, directory: Path = Path()) -> WagonScenario:
    """Return a scenario of the wagon by name or path; see `load_twin`."""
    return load_twin(WagonScenario, "wagon", name, directory)


def run_wagon(scenario: WagonScenario, seed: int | None = None) -> xarray.Dataset:
    """Return the recording of a run, from its start to the stop or the horizon.

    The true adhesion is that of both wheelsets together, ΣF_x/ΣF_z. `wheel_torque` is the known resistance of bearings
    and rolling, from the plant: the linear input of the paper's equation (14).

    Raises:
        EstimationError: The plant has no such parameter.
        PlantFailed: The plant refused a step.
    """
    random = generator(scenario.seed if seed is None else seed, "wagon.sensors")
    steps = math.floor(scenario.horizon / scenario.period + 1e-9)
    time = np.arange(steps + 1) * scenario.period
    demand = np.array(scenario.demand)
    place = np.searchsorted(demand[:, 0], time + 1e-9, side="right") - 1
    pressure = np.where(place[:, None] >= 0, demand[np.maximum(place, 0), 1:], 0.0)
    mu0 = np.interp(time, *np.array(scenario.mu0).T)
    inputs = np.column_stack([pressure, mu0, mu0, np.full(time.size, scenario.track_force)])
    values = {"speed_start": scenario.speed_start} | parameters(
        PLANT, scenario.parameters, f"{scenario.name}: [parameters]"
    )
    rows: list[Vector] = []
    with plant(PLANT, inputs=INPUTS, outputs=OUTPUTS, period=scenario.period, parameters=values) as wagon:
        rows.append(wagon.start(inputs[0]))
        for k in range(steps):
            rows.append(wagon.step(inputs[k]))
            if rows[-1][2] <= scenario.stop_speed:
                break
    truth = np.array(rows)
    w, v, force, alpha, load, mu, resistance = np.split(truth, [2, 3, 5, 7, 9, 11], axis=1)
    its = scenario.sensors
    count = len(truth)
    signals = {
        "speed": (v[:, 0] + its.speed * random.standard_normal(count), "m/s"),
        "track_force": (np.full(count, scenario.track_force), "N"),
    }
    told = {"v": (v[:, 0], "m/s"), "alpha": ((alpha * load).sum(axis=1) / load.sum(axis=1), "1")}
    for i in range(2):
        noise = random.standard_normal((2, count))
        signals[f"wheelset_speed[{i + 1}]"] = (w[:, i] + its.wheelset_speed * noise[0], "rad/s")
        signals[f"pad_force[{i + 1}]"] = (force[:, i] + its.pad_force * noise[1], "N")
        signals[f"wheel_torque[{i + 1}]"] = (-resistance[:, i], "N.m")
        told[f"w[{i + 1}]"] = (w[:, i], "rad/s")
        told[f"mu_b[{i + 1}]"] = (mu[:, i], "1")
    return recording_of(signals, period=scenario.period, truth=told, name=scenario.name)
