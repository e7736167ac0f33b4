"""The front of an emergency brake through ten coaches: its speed over grids, branches and accelerators."""

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any

import numpy as np
from typer import Option

from railgrip.base.cache import VARIABLE
from railgrip.base.files import scratch, write_text
from railgrip.campaign.work import Work
from railgrip.campaign.workers import environment
from railgrip.fmi import Description
from railgrip.fmi.description import describe
from railgrip.fmi.mapping import Port, bind
from railgrip.fmi.plant import CoSimulation
from railgrip.fmus.build import build_class
from railgrip.report.baseline import Finding
from railgrip.report.page import Page
from railgrip.report.table import ReportTable, percent, write_tables
from railgrip.rolling_stock.modelica import CELLS_OF_A_CAR
from railgrip.rolling_stock.schema import load_train
from railgrip.rolling_stock.stopping import by_hand, chain_forces
from railgrip.scenario.file import inline_toml, locate, merge
from railgrip.scenario.load import read_toml
from railgrip.simulate.named_models import plant_description
from railgrip.simulate.run import run_stop
from railgrip.studies.bench import plant_step
from railgrip.studies.study import Study
from railgrip.studies.trains.stops import FULL_BRAKE, dry_scenario, filling_of

PAGE = Path("docs/train_models.md")
"""Folder relative to that of the project, in which the command runs."""

GRIDS = (1, 3, CELLS_OF_A_CAR, 9, 17)
"""Cells of the pipe in a car; grid errors are differences from the last."""
QUICK_GRIDS = (CELLS_OF_A_CAR, 9)
LITRES = (0.0, 1.5, 3.0, 4.5)
"""Volume of the branch of each car [l]."""
CONDUCTANCES = {"none": 0.0, "in each car": 2e-7}
"""Sonic conductance of accelerators [m3/(s.Pa)]."""
LIMIT = 250.0
"""Slowest front that UIC 540 permits [m/s]."""

_LENGTHS = np.array([19.5, *[26.4] * 10])
_PRESSURE = 3.8e5
FREIGHT, FREIGHT_SPEED, WAGONS = "freight_train", 100 / 3.6, (5, 10, 20, 40)
"""Train, initial speed [m/s], and numbers of wagons."""
_PERIOD, _STEPS = 2e-3, 1500  # s; the valve opens after 1 s
_FIRST = 0.05  # of the highest pressure, at which a cylinder has begun to fill

EQUIPMENT: Mapping[str, Mapping[str, Any]] = read_toml(Path(__file__).with_suffix(".toml"))
"""Equipment of each car of `loco_coaches`: the tables that docs/trains.md explains."""

_MODEL = """model Pipe
  extends RailBraking.Examples.BrakePipeOfTenCoaches(cells=CELLS);
  RailBraking.Interfaces.RealOutput pressure[n](each final unit="Pa") = distributor.pressure;
end Pipe;
"""

Case = tuple[float, str]
"""Volume of branches [l], accelerators."""


def fronts(cells: int) -> dict[Case, float]:
    """Return the speed of the front from the first vehicle to the last [m/s], with `cells` for each."""
    with scratch("study") as folder:
        source = folder / "Pipe.mo"
        source.write_text(_MODEL.replace("CELLS", str(cells)), encoding="utf-8")
        description = describe(build_class("Pipe", source, compiler="native").path)
    return {
        (litres, name): _front(description, 1e-3 * litres, conductance)
        for litres in LITRES
        for name, conductance in CONDUCTANCES.items()
    }


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


def freight_row(wagons: int) -> dict[str, object]:
    """Return size and durations of a freight train, and its emergency stop from 100 km/h on a dry rail."""
    with scratch("study") as folder:
        file = folder / f"{FREIGHT}.toml"
        file.write_text(freight_train(wagons, folder.as_posix()), encoding="utf-8")
        train, scenario = load_train(file), dry_scenario(file, FREIGHT_SPEED)
        with environment({VARIABLE: f"{folder}/cache"}):  # everything is built
            begin, start = sum(os.times()[:4]), perf_counter()  # the C compiler is a child
            plant = plant_description(scenario)
            processor, wall = sum(os.times()[:4]) - begin, perf_counter() - start
        step = plant_step(plant, FULL_BRAKE, count=500, rounds=3)
        trace = run_stop(scenario).trace
    hand = by_hand(train, FREIGHT_SPEED)
    forces = {
        "pushes": -trace["coupler_force"].values,
        "pulls": trace["coupler_force"].values,
        "quasi-static": np.abs(hand.coupler_force),
        "chain": chain_forces(train, hand),
    }
    return {
        "wagons": wagons,
        "states": len(plant.states),
        "build": wall,
        "of the processor": processor,
        "step and wagon": step / wagons,
        "simulated": float(trace["distance"].values[-1]),
        "by hand": hand.distance,
        **{name: 1e-3 * float(force.max()) for name, force in forces.items()},
    }


def table_of(speeds: Mapping[Any, Mapping[Case, float]]) -> ReportTable:
    """Return the front over grids, and the grid error of the trains in files."""
    finest = max(speeds)
    rows = [
        {"branch": f"{litres:g} l", "accelerators": name}
        | {f"{cells} {'cells' if cells > 1 else 'cell'}": f"{speeds[cells][litres, name]:.1f} m/s" for cells in speeds}
        | {"grid error": speeds[CELLS_OF_A_CAR][litres, name] / speeds[finest][litres, name] - 1}
        for litres, name in speeds[finest]
    ]
    return ReportTable(rows, {"grid error": percent}, ("branch", "accelerators"), title="Front through ten coaches")


def stop_row(equipment: str) -> dict[str, object]:
    """Return the dry stop of `loco_coaches` with some equipment in each car."""
    tables = EQUIPMENT[equipment]
    fitted = {kind.removesuffix("s"): name for kind, of_kind in tables.items() for name in of_kind}
    content = merge(read_toml(locate("loco_coaches", "trains")), tables)
    content["cars"] = [car | fitted for car in content["cars"]]
    with scratch("study") as folder:
        file = folder / "loco_coaches.toml"
        write_text(file, "".join(f"{key} = {inline_toml(value)}\n" for key, value in content.items()))
        train = load_train(file)
        speed = train.reference[0].speed
        trace = run_stop(dry_scenario(file, speed)).trace
    filling = filling_of(train, trace)
    return {
        "`loco_coaches` from 160 km/h": equipment,
        "simulated": float(trace["distance"].values[-1]),
        "by hand": by_hand(train, speed).distance,
        "last car begins": float(filling.begin[-1]),
        "filling to 95 %": float(filling.filling.max()),
        "largest coupler force": 1e-3 * float(np.abs(trace["coupler_force"].values).max()),
    }


@dataclass(frozen=True)
class BrakePipeStudy(Study, quick="two grids, and no stops of trains"):
    """Measure the front in the brake pipe of ten coaches, over cells, branch volumes and accelerators."""

    write: Annotated[bool, Option("--write", help="Write the table into docs/train_models.md.")] = False

    def page(self, work: Work) -> Page:
        """Return the speed of the front in each case; the small form has two grids."""
        grids = QUICK_GRIDS if self.quick else GRIDS
        speeds = dict(zip(grids, work.map(fronts, grids), strict=True))
        table, of_trains = table_of(speeds), speeds[CELLS_OF_A_CAR].values()
        rows = [] if self.quick else work.map(stop_row, EQUIPMENT)
        # One after the other, in this process: other processes would change the durations.
        long = [] if self.quick else [freight_row(wagons) for wagons in WAGONS]
        freight = ReportTable(long, _FORMS, ("wagons",), title="Freight trains of the wagons of `freight_train`")
        stops = ReportTable(rows, _FORMS, ("`loco_coaches` from 160 km/h",), title="Emergency stops on a dry rail")
        if self.write:
            write_tables(PAGE, {"fronts": table, "stops": stops, "freight": freight})
        return Page(
            title="Front of an emergency brake in the brake pipe",
            question="How fast does an emergency brake run through ten coaches, and how large is the grid error?",
            answer=f"With {CELLS_OF_A_CAR} cells a vehicle, as in trains in files, the front runs at "
            f"{min(of_trains):.0f} to {max(of_trains):.0f} m/s, depending on branches and accelerators. "
            f"UIC 540 requires {LIMIT:g} m/s.",
            template="studies/brake_pipe.md.jinja",
            values={
                "fronts": table,
                "stops": stops,
                "freight": freight,
                "limit": LIMIT,
                "cells": CELLS_OF_A_CAR,
                "finest": max(grids),
            },
            tables={"fronts.csv": table},
            screen=(table, stops, freight),
        )

    def headlines(self, work: Work) -> list[Finding]:
        """Return the front with branches of 3 l, without and with accelerators."""
        (speeds,) = work.map(fronts, [CELLS_OF_A_CAR])
        # Between two outputs of 2 ms: half a metre a second.
        return [Finding(f"accelerators {name}: front", speeds[3.0, name], "m/s", 0.1) for name in CONDUCTANCES]


STUDY = BrakePipeStudy

_FORMS = {
    **dict.fromkeys(("simulated", "by hand"), "{:.1f} m"),
    **dict.fromkeys(("last car begins", "filling to 95 %"), "{:.2f} s"),
    **dict.fromkeys(("largest coupler force", "pushes", "pulls", "quasi-static", "chain"), "{:.1f} kN"),
    **dict.fromkeys(("build", "of the processor"), "{:.1f} s"),
    "step and wagon": "{:.1f} µs",
}
