"""Computing time of a co-simulation step through this project's interface, through FMPy, and in a loop in C."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from statistics import median

import numpy as np

from railgrip.base.names import ElementName
from railgrip.fmi.comparison import seconds_in_c, seconds_of_fmpy, seconds_of_railgrip
from railgrip.fmi.description import Description, describe
from railgrip.fmi.mapping import Binding, Port, bind
from railgrip.fmus.build import fmu
from railgrip.studies.bench import Row


def steps_of(recipe: str) -> Iterator[Row]:
    """Yield the time of set + step of 1 ms + get of a recipe by each interface."""
    times = step_times(fmu(recipe))

    def over_ours(way: str) -> str:
        return f"{median(a / b for a, b in zip(times[way], times['ours'], strict=True)):.2f}"

    ours_over_c = median(a / b for a, b in zip(times["ours"], times["c"], strict=True))
    yield f"{recipe}: set + step of 1 ms + get, ours", f"{median(times['ours']):.1f} µs", ""
    yield "  the same in a loop in C", f"{median(times['c']):.1f} µs", "10 µs"
    yield "  FMPy's FMU2Slave over ours", over_ours("fmpy"), ""
    yield "  ours over C", f"{ours_over_c:.2f}", ""


def step_times(file: Path, *, period: float = 1e-3, count: int = 2000, rounds: int = 9) -> dict[str, list[float]]:
    """Step an FMU by each interface in turn, repeatedly; return interface → time of a step in each round [µs].

    Every run begins with the start values, so that all do the same work, and all must end with the same outputs.

    Args:
        file: A co-simulation FMU; its Real inputs are held at their start values.
        period: Communication step [s].
        count: Steps of one run.

    Raises:
        AssertionError: Two interfaces return different outputs, so that their times cannot be compared.
    """
    description = describe(file)
    binding, inputs = every_real(description, {})
    run: dict[str, Callable[..., tuple[float, np.ndarray]]] = {
        "ours": seconds_of_railgrip,
        "fmpy": seconds_of_fmpy,
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
    return times


def plant_step(
    description: Description, inputs: Mapping[str, float], *, period: float = 1e-3, count: int = 500, rounds: int = 15
) -> float:
    """Return the shortest time of set + step + get of a plant in a loop in C [µs].

    It is the shortest of several runs, each from the start, because other processes can only increase the time.

    Args:
        description: Description of a co-simulation FMU.
        inputs: Values of inputs by name, for arrays of all elements; other inputs have their start values.
        period: Communication step [s].
        count: Steps of one run.
    """
    binding, values = every_real(description, inputs)
    runs = (seconds_in_c(description, binding, values, period=period, count=count)[0] for _ in range(rounds))
    return min(runs) / count * 1e6


def every_real(description: Description, inputs: Mapping[str, float]) -> tuple[Binding, np.ndarray]:
    """Tie every Real input and output of an FMU to itself; return also the inputs, as given or at the start."""

    def signals(names: tuple[str, ...]) -> list[Port]:
        variables = [description.variables[name] for name in names]
        return [Port(name=v.name, unit=v.unit or "1", size=0, needed=True) for v in variables if v.kind == "Real"]

    binding = bind(
        description, inputs=signals(description.names("input")), outputs=signals(description.names("output"))
    )
    names = binding.inputs.elements
    return binding, np.array(
        [inputs.get(ElementName.of(v).array, float(description.variables[v].start_text or 0.0)) for v in names]
    )
