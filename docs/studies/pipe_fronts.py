"""The front of an emergency brake through ten coaches, stops with other equipment, and long freight trains."""

import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from train_stops import dry_scenario, filling_of

import railgrip as rg
from railgrip.base.cache import VARIABLE
from railgrip.base.files import scratch, write_text
from railgrip.campaign.workers import environment
from railgrip.fmi import Description
from railgrip.fmi.description import describe
from railgrip.fmi.mapping import Port, bind
from railgrip.fmi.plant import CoSimulation
from railgrip.fmus.build import build_class
from railgrip.report.baseline import Finding
from railgrip.rolling_stock.modelica import CELLS_OF_A_CAR
from railgrip.rolling_stock.schema import load_train
from railgrip.rolling_stock.stopping import by_hand, chain_forces
from railgrip.scenario.file import inline_toml, locate, merge
from railgrip.scenario.load import read_toml
from railgrip.simulate.named_models import plant_description
from railgrip.simulate.run import run_stop
from railgrip.studies.bench import plant_step

LITRES = (0.0, 1.5, 3.0, 4.5)
"""Volume of the branch of each car [l]."""
CONDUCTANCES = {"none": 0.0, "in each car": 2e-7}
"""Sonic conductance of accelerators [m3/(s.Pa)]."""

_LENGTHS = np.array([19.5, *[26.4] * 10])
_PRESSURE = 3.8e5
FREIGHT, FREIGHT_SPEED, WAGONS = "freight_train", 100 / 3.6, (5, 10, 20, 40)
"""Train, initial speed [m/s], and numbers of wagons."""
_FULL_BRAKE = {"pressure_command": 1e7, "mu0": 0.5}
_PERIOD, _STEPS = 2e-3, 1500  # s; the valve opens after 1 s
_FIRST = 0.05  # of the highest pressure, at which a cylinder has begun to fill

EQUIPMENT: Mapping[str, Mapping[str, Any]] = {
    "as in its file": {},
    "distributors in position R": {
        "distributors": {
            "R": {"low_share": 0.5, "speed_up": "70 km/h", "speed_down": "50 km/h", "stage_time": "0.3 s",
                  "estimated": True}
        }
    },
    "accelerators": {
        "accelerators": {
            "quick": {"conductance": "2e-7 m3/(s.Pa)", "opening_rate": "0.7 bar/s", "closing_pressure": "2.5 bar",
                      "sensing_time": "0.3 s", "estimated": True}
        }
    },
}  # fmt: skip
"""Equipment of each car of `loco_coaches`: the tables that docs/trains.md explains."""

_MODEL = """model Pipe
  extends RailBraking.Examples.BrakePipeOfTenCoaches(cells=CELLS);
  RailBraking.Interfaces.RealOutput pressure[n](each final unit="Pa") = distributor.pressure;
end Pipe;
"""


def fronts(cells: int, litres: Sequence[float] = LITRES) -> list[dict[str, Any]]:
    """Return the speed of the front from the first vehicle to the last [m/s], with `cells` for each vehicle.

    A row for each volume of the branches [l], without and with accelerators.
    """
    with scratch("study") as folder:
        source = folder / "Pipe.mo"
        source.write_text(_MODEL.replace("CELLS", str(cells)), encoding="utf-8")
        description = describe(build_class("Pipe", source, compiler="native").path)
    return [
        {"litres": volume, "accelerators": name, "front": _front(description, 1e-3 * volume, conductance)}
        for volume in litres
        for name, conductance in CONDUCTANCES.items()
    ]


def _front(description: Description, volume: float, conductance: float) -> float:
    pressures = Port(name="pressure", unit="Pa", size=_LENGTHS.size, needed=True)
    binding = bind(description, inputs=[], outputs=[pressures])
    parameters = {"V_branch": volume, "C_accelerator": conductance}
    with CoSimulation(description, binding, period=_PERIOD, parameters=parameters) as pipe:
        first = pipe.start(np.zeros(0)).copy()
        pressure = np.array([first, *(pipe.step(np.zeros(0)).copy() for _ in range(_STEPS))])
    time = _PERIOD * np.arange(_STEPS + 1)
    begin = [np.interp(_FIRST * _PRESSURE, of_vehicle, time) for of_vehicle in pressure.T]
    middle = np.cumsum(_LENGTHS) - _LENGTHS / 2
    return float((middle[-1] - middle[0]) / (begin[-1] - begin[0]))


def freight_train(wagons: int, title: str) -> str:
    """Return the file of `freight_train` with its first wagons only, and with another description."""
    text = locate(FREIGHT, "trains").read_text(encoding="utf-8").replace(f"count = {max(WAGONS)}", f"count = {wagons}")
    return re.sub(r"^description = .*$", lambda _: f'description = "{title}"', text, count=1, flags=re.MULTILINE)


def freight_row(wagons: int) -> dict[str, float]:
    """Return size and durations of a freight train, and its emergency stop from 100 km/h on a dry rail."""
    with scratch("study") as folder:
        file = folder / f"{FREIGHT}.toml"
        file.write_text(freight_train(wagons, folder.as_posix()), encoding="utf-8")
        train, scenario = load_train(file), dry_scenario(file, FREIGHT_SPEED)
        with environment({VARIABLE: f"{folder}/cache"}):  # everything is built
            begin, start = sum(os.times()[:4]), perf_counter()  # the C compiler is a child
            plant = plant_description(scenario)
            processor, wall = sum(os.times()[:4]) - begin, perf_counter() - start
        step = plant_step(plant, _FULL_BRAKE, count=500, rounds=3)
        trace = run_stop(scenario).trace
    hand = by_hand(train, FREIGHT_SPEED)
    forces = {
        "pushes": -trace["coupler_force"].values,
        "pulls": trace["coupler_force"].values,
        "quasi-static": np.abs(hand.coupler_force),
        "chain": chain_forces(train, hand),
    }
    return {
        "states": len(plant.states),
        "build": wall,
        "of the processor": processor,
        "step and wagon": step / wagons,
        "simulated": float(trace["distance"].values[-1]),
        "by hand": hand.distance,
        **{name: 1e-3 * float(force.max()) for name, force in forces.items()},
    }


def equipment_row(equipment: str) -> dict[str, float]:
    """Return the dry stop of `loco_coaches` with some equipment in each car, a key of `EQUIPMENT`."""
    tables = EQUIPMENT[equipment]
    fitted = {kind.removesuffix("s"): name for kind, of_kind in tables.items() for name in of_kind}
    # With other equipment the train need not meet the published limit of its file.
    content = merge(read_toml(locate("loco_coaches", "trains")), tables) | {"reference": []}
    content["cars"] = [car | fitted for car in content["cars"]]
    with scratch("study") as folder:
        file = folder / "loco_coaches.toml"
        write_text(file, "".join(f"{key} = {inline_toml(value)}\n" for key, value in content.items()))
        train, speed = load_train(file), load_train(Path("loco_coaches")).reference[0].speed
        trace = run_stop(dry_scenario(file, speed)).trace
    filling = filling_of(train, trace)
    return {
        "simulated": float(trace["distance"].values[-1]),
        "by hand": by_hand(train, speed).distance,
        "last car begins": float(filling.begin[-1]),
        "filling to 95 %": float(filling.filling.max()),
        "largest coupler force": 1e-3 * float(np.abs(trace["coupler_force"].values).max()),
    }


def headlines() -> list[Finding]:
    """Return the front with branches of 3 l, without and with accelerators, for the regression."""
    frame = rg.evaluate(fronts, [{"cells": CELLS_OF_A_CAR}])
    rows = frame[frame["litres"] == 3.0].itertuples()
    # Between two outputs of 2 ms: half a metre a second.
    return [Finding(f"accelerators {row.accelerators}: front", row.front, "m/s", 0.1) for row in rows]
