"""What a co-simulation step costs by our way across the boundary, by FMPy's, and in a loop in C."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np

from railgrip.fmu.comparison import seconds_in_c, seconds_of_fmpy, seconds_of_ours, seconds_of_simulate_fmu
from railgrip.fmu.description import Description, describe
from railgrip.fmu.mapping import Binding, Signal, bind


@dataclass(frozen=True, slots=True, kw_only=True)
class StepCost:
    """Cost of set + step + get of one FMU.

    Attributes:
        file: Name of the FMU.
        inputs: Number of Real inputs set.
        outputs: Number of Real outputs read.
        ours: Median time of a step through `CoSimulation` [µs].
        fmpy: Through FMPy's FMU2Slave [µs].
        simulate_fmu: Through fmpy.simulate_fmu [µs].
        c: In a loop in C [µs].
        overhead: Median of ours − C over paired runs: what Python costs [µs].
        fmpy_over_ours: Median ratio of paired runs.
        simulate_fmu_over_ours: Median ratio of paired runs.
        ours_over_c: Median ratio of paired runs.
    """

    file: str
    inputs: int
    outputs: int
    ours: float
    fmpy: float
    simulate_fmu: float
    c: float
    overhead: float
    fmpy_over_ours: float
    simulate_fmu_over_ours: float
    ours_over_c: float


def step_cost(file: Path, *, period: float = 1e-3, count: int = 2000, rounds: int = 9) -> StepCost:
    """Step an FMU by each way in turn, over and over, and compare.

    Every run begins anew from the start values, so that all do the same work, and all must end on the same outputs.

    Args:
        file: A co-simulation FMU; its Real inputs are held at their start values.
        period: Communication step [s].
        count: Steps of one run.

    Raises:
        AssertionError: Two ways disagree on the outputs; then their times mean nothing.
    """
    description = describe(file)
    binding = every_real(description)
    inputs = np.array([float(description.variables[v].start or 0.0) for v in binding.inputs.elements])
    run: dict[str, Callable[..., tuple[float, np.ndarray]]] = {
        "ours": seconds_of_ours,
        "fmpy": seconds_of_fmpy,
        "simulate_fmu": seconds_of_simulate_fmu,
        "c": seconds_in_c,
    }
    times: dict[str, list[float]] = {way: [] for way in run}
    last: dict[str, np.ndarray] = {}
    for _ in range(rounds):
        for way, seconds in run.items():
            time, last[way] = seconds(description, binding, inputs, period=period, count=count)
            times[way].append(time / count * 1e6)
    for way in ("fmpy", "c"):
        if not np.array_equal(last[way], last["ours"]):
            raise AssertionError(f"{file.name}: {way} and ours end on different outputs, so they did not do the same.")
    # simulate_fmu lets the FMU keep its own time grid, whose last point may differ in rounding.
    np.testing.assert_allclose(last["simulate_fmu"], last["ours"], rtol=1e-6, atol=1e-9)

    def ratio(above: str, below: str) -> float:
        return median(a / b for a, b in zip(times[above], times[below], strict=True))

    return StepCost(
        file=file.name,
        inputs=binding.inputs.size,
        outputs=binding.outputs.size,
        ours=median(times["ours"]),
        fmpy=median(times["fmpy"]),
        simulate_fmu=median(times["simulate_fmu"]),
        c=median(times["c"]),
        overhead=median(a - b for a, b in zip(times["ours"], times["c"], strict=True)),
        fmpy_over_ours=ratio("fmpy", "ours"),
        simulate_fmu_over_ours=ratio("simulate_fmu", "ours"),
        ours_over_c=ratio("ours", "c"),
    )


def every_real(description: Description) -> Binding:
    """Tie every Real input and output of an FMU to itself."""

    def signals(names: tuple[str, ...]) -> list[Signal]:
        variables = [description.variables[name] for name in names]
        return [
            Signal(name=v.name, unit=v.unit_name or "1", size=0, needed=True) for v in variables if v.kind == "Real"
        ]

    return bind(description, inputs=signals(description.names("input")), outputs=signals(description.names("output")))
