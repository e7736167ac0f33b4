"""What a train costs as it grows: time to build its FMU, and to step it."""

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np

from railgrip.bench.fmi import every_real
from railgrip.fmu.comparison import seconds_in_c
from railgrip.fmu.description import describe
from railgrip.fmus.build import build_class

BRAKING = {"pressure_command": 2.5e5, "mu0": 0.3}
"""Inputs of a service braking on a rail that holds it; pressure [Pa]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConsistCost:
    """Cost of a train of equal four-axle cars with bogie frames on primary suspension and a brake on each axle.

    Attributes:
        cars: Number of cars.
        states: Of its FMU.
        build: From Modelica to FMU, nothing of it kept from before [s].
        step: Of 1 ms, set and get included, in a loop in C; see `plant_step` [µs].
    """

    cars: int
    states: int
    build: float
    step: float


def plant_step(
    file: Path, inputs: Mapping[str, float], *, period: float = 1e-3, count: int = 500, rounds: int = 15
) -> float:
    """Return the time of set + step + get of a plant in a loop in C, at its shortest [µs].

    The shortest of several runs, each from the start: what else the machine does can only add to it.

    Args:
        file: A co-simulation FMU.
        inputs: Values of inputs by name, for arrays of all elements; those not named stay at their start values.
        period: Communication step [s].
        count: Steps of one run.
    """
    description = describe(file)
    binding = every_real(description)
    names = binding.inputs.elements
    start_values = [inputs.get(v.partition("[")[0], float(description.variables[v].start or 0.0)) for v in names]
    runs = (
        seconds_in_c(description, binding, np.array(start_values), period=period, count=count) for _ in range(rounds)
    )
    return min(seconds for seconds, _ in runs) / count * 1e6


def consist_costs(numbers: Sequence[int] = (1, 2, 4, 8, 16)) -> Iterator[ConsistCost]:
    """Yield the costs of trains of these numbers of cars, from `RailBraking.FMUs.Consist`."""
    for cars in numbers:
        with tempfile.TemporaryDirectory() as folder:
            # A name that was never built: the description string is part of what the cache looks up.
            source = Path(folder) / "Cars.mo"
            source.write_text(f'block Cars "{folder}"\n  extends RailBraking.FMUs.Consist(cars={cars});\nend Cars;\n')
            begin = perf_counter()
            built = build_class("Cars", source, compiler="native")
            build = perf_counter() - begin
            states = sum(v.name.startswith("der(") for v in describe(built.path).variables.values())
            yield ConsistCost(cars=cars, states=states, build=build, step=plant_step(built.path, BRAKING))
