"""Computing time of stops: steps of FMUs, their build, a cycle of the loop, parallel stops, and growing trains."""

import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

import numpy as np
from numpy.typing import NDArray

from railgrip.base.cache import VARIABLE
from railgrip.base.names import ElementName
from railgrip.campaign.run import CampaignRun, run_campaigns
from railgrip.campaign.workers import environment
from railgrip.controllers.observation import Observation
from railgrip.fmi.description import Description, describe
from railgrip.fmi.mapping import Binding, Port, bind
from railgrip.fmi.survey import seconds_in_c, seconds_of_fmpy, seconds_of_railgrip
from railgrip.fmus.build import build, build_class, fmu
from railgrip.fmus.recipe import read_recipes
from railgrip.scenario.campaign import Campaign, PlannedStop
from railgrip.scenario.load import load
from railgrip.simulate.assembly import assemble
from railgrip.simulate.loop.loop import Loop
from railgrip.simulate.run import braking_distance, run_stop
from railgrip.simulate.user_parts import CustomParts
from railgrip.studies.bench import Row, microseconds
from railgrip.vehicle.formation import Formation


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


ABC = "peak seeking (railgrip)"
CYCLE = ": a cycle, law compiled"
FASTER = "  with assembly and figures, times faster than real time"
"""Names of rows that the study's answer quotes."""

AT_LEAST = "at least "
"""Prefix of a target that is a lower limit; other targets are upper limits."""

BRAKING = {"pressure_command": 2.5e5, "mu0": 0.3}
"""Inputs of a service braking without slides; pressure [Pa]."""


class PythonSlipControl:
    """The library's two-state slip control as a user's class, a few lines that take a few microseconds."""

    def start(self, formation: Formation) -> None:
        """Set the maximum pressures, and brake every group."""
        self._full, self._brakes = formation.pressure_max, np.ones(formation.groups, dtype=bool)

    def decide(self, observation: Observation) -> NDArray[np.float64]:
        """Return full pressure for each group, or zero from 15 % slip until 10 %."""
        self._brakes = np.where(self._brakes, observation.slip <= 0.15, observation.slip < 0.1)
        return np.where(self._brakes, self._full, 0.0)


def of_scenario(what: str, *overrides: str) -> Iterator[Row]:
    """Yield the time of a cycle of 1 ms in the library's trapezoid, alternately with a compiled law and one in Python.

    A first run compiles everything.
    """
    scenario = load(Path("trapezoid"), ["controller.kind=slip_two_state", *overrides])
    simulated = run_stop(scenario).metrics.duration
    cycles = simulated / scenario.periods.communication
    laws = {"compiled": CustomParts(), "Python": CustomParts(controller=PythonSlipControl())}
    cycle: dict[str, list[float]] = {name: [] for name in laws}
    for _ in range(3):
        for name, entry in laws.items():
            with assemble(scenario, objects=entry) as parts:
                begin = process_time()
                parts.run()
                cycle[name].append((process_time() - begin) / cycles * 1e6)
    alone = PythonSlipControl()
    with assemble(scenario, objects=CustomParts(controller=alone)) as parts:
        observation = next(Loop(parts.parts).decisions())
        law = microseconds(lambda: alone.decide(observation), rounds=5)
    compiled, python = (median(cycle[name]) for name in laws)
    figures = microseconds(lambda: run_stop(scenario), rounds=3, clock=process_time) / cycles
    bare = microseconds(lambda: braking_distance(scenario), rounds=5, clock=process_time) / cycles
    yield f"{what}{CYCLE}", f"{compiled:.1f} µs", ""
    yield "  with assembly and figures", f"{figures:.1f} µs", ""
    yield FASTER, f"{1e6 * scenario.periods.communication / figures:.0f}", ""
    yield "  with assembly, without a trace", f"{bare:.1f} µs", "10 µs"
    yield "  a cycle, the same law in Python", f"{python:.1f} µs", ""
    yield "  of that the law itself", f"{law:.1f} µs", ""
    yield "  law in Python over compiled, the law's own time apart", f"{(python - law) / compiled:.2f}", "1.5"


def of_predictions() -> Iterator[Row]:
    """Yield the time of a stop without a trace for each kind of filter, and interface of its FMU, in turn."""
    kinds = ("compiled", "fmu", "co_simulation", "python")
    changes = {kind: [f"estimator.kind={kind}"] for kind in kinds} | {
        "co_simulation": ["estimator.interface=co_simulation"]
    }
    scenarios = {kind: load(Path("trapezoid"), changes[kind]) for kind in kinds}
    seconds: dict[str, list[float]] = {kind: [] for kind in kinds}
    for scenario in scenarios.values():
        braking_distance(scenario)  # compiles everything
    for _ in range(3):
        for kind, scenario in scenarios.items():
            begin = process_time()
            braking_distance(scenario)
            seconds[kind].append(process_time() - begin)
    compiled, fmu, co_simulation, python = (median(seconds[kind]) for kind in kinds)
    yield "a stop with the filter over compiled equations", f"{compiled:.2f} s", ""
    yield "  over the prediction FMU", f"{fmu:.2f} s", ""
    yield "  over the prediction FMU that integrates itself, Co-Simulation", f"{co_simulation:.2f} s", ""
    yield "  in numpy over the equations", f"{python:.2f} s", ""
    yield "  prediction FMU over compiled", f"{fmu / compiled:.2f}", "2.5"


def of_workers(count: int = 24) -> Iterator[Row]:
    """Yield the speed-up of two processes over one.

    It is measured from the end of the first stop to that of the last, without the start of processes, which takes
    seconds.
    """
    stops = tuple(
        PlannedStop(name=f"{lot}", variants={}, scenario=load(Path("trapezoid"), [f"seed={lot}"]), keep_trace=False)
        for lot in range(count)
    )
    campaign = Campaign(name="bench", description="", stops=stops, references=())
    rates: list[float] = []
    for workers in (1, 2):
        ends: list[float] = []
        with tempfile.TemporaryDirectory() as folder:
            run_campaigns(
                [CampaignRun(campaign, Path(folder))], run_stop,
                workers=workers, notify=lambda report, ends=ends: ends.append(perf_counter()),
            )  # fmt: skip
        rates.append((count - workers) / (ends[-1] - ends[workers - 1]))
    yield "stops that two processes end, over one", f"{rates[1] / rates[0]:.2f}", f"{AT_LEAST}1.9"


def of_consists() -> Iterator[Row]:
    """Yield step and build of trains of equal four-axle cars with bogie frames on primary suspension.

    Each axle has a brake; the build does not use the cache.
    """
    for cars in (1, 2, 4, 8, 16):
        with tempfile.TemporaryDirectory() as folder:
            # A name that was never built: the description string is part of what the cache looks up.
            source = Path(folder) / "Cars.mo"
            meaning = Path(folder).as_posix()
            text = f'block Cars "{meaning}"\n  extends RailBraking.Plants.Consist(cars={cars});\nend Cars;\n'
            source.write_text(text, encoding="utf-8")
            begin = perf_counter()
            description = describe(build_class("Cars", source, compiler="native").path)
            seconds = perf_counter() - begin
            step, states = plant_step(description, BRAKING), len(description.states)
            what = f"train of {cars} four-axle cars, {states} states: step of 1 ms in a loop in C"
            yield what, f"{step:.1f} µs", "25 µs for four cars" if cars == 4 else ""
            yield "  build of its FMU", f"{seconds:.1f} s", "30 s for eight cars" if cars == 8 else ""


def of_recipes() -> Iterator[Row]:
    """Yield the cold build of every recipe: into an empty folder, with nothing in the user's cache."""
    names = list(read_recipes().recipes)
    with tempfile.TemporaryDirectory() as folder, environment({VARIABLE: f"{folder}/cache"}):
        before, start = _processor(), perf_counter()
        for _ in build(names, "native", Path(folder)):
            pass
        wall, processor = perf_counter() - start, _processor() - before
    yield f"cold build of {len(names)} FMUs", f"{wall:.1f} s ({processor:.1f} s of processor)", "10 s"


def _processor() -> float:
    """Return the CPU time of this process and of the children it has waited for [s]."""
    return sum(os.times()[:4])
