"""What a stop costs: the build of the FMUs, a filter step, a cycle of the loop, a plant step."""

import os
import resource
import tempfile
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

import numpy as np

from railgrip.assemble import braking_distance, run_stop
from railgrip.assemble.files import lowered
from railgrip.assemble.prediction import consist_of, start_of
from railgrip.cache import VARIABLE
from railgrip.engine import Engine
from railgrip.estimators.belief import Estimate, Vector
from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.decentralised import DecentralisedFilter
from railgrip.estimators.ekf import ExtendedKalmanFilter
from railgrip.estimators.prediction import CasadiPrediction
from railgrip.estimators.tuning import NOISE_SETS
from railgrip.formation import Formation
from railgrip.scenario.load import load

LIBRARY = Path(__file__).parents[1] / "scenario" / "library"


@dataclass(frozen=True, slots=True, kw_only=True)
class FilterCost:
    """Medians over rounds [µs].

    Attributes:
        states: Of the model.
        advance: Compiled, in place, as the loop uses it.
        step: Compiled, on values.
        reference: The filter in numpy; NaN where it was not stepped.
    """

    states: int
    advance: float
    step: float
    reference: float = float("nan")


def filter_cost(model: str, noise: str, *, count: int = 2000, rounds: int = 9) -> FilterCost:
    """Step both filters over a braked train with readings that fit it."""
    translation = lowered(f"RailBraking.FMUs.{model}")
    prediction = CasadiPrediction(translation, {v.name: v.start for v in translation.parameters})
    noise_set = NOISE_SETS[noise]
    noises = noise_set.process_noise(prediction.states), noise_set.reading_noise(prediction.outputs)
    compiled = CompiledFilter(prediction, *noises, 1e-3)
    plain = ExtendedKalmanFilter(prediction, *noises, 1e-3)
    mean = np.array([v.start for v in translation.states])
    spread = noise_set.start_covariance(prediction.states)
    inputs = np.array([2e5, 1e5, 1e5, 2e5, 0.0])
    readings = prediction.output(mean, inputs)
    first = compiled.start(mean, spread)
    advance, step = step_times(compiled, first, inputs, readings, count, rounds)
    reference: list[float] = []
    for _ in range(rounds):
        belief = first
        start = perf_counter()
        for _ in range(count // 20):
            belief = plain.step(belief, inputs, readings)
        reference.append((perf_counter() - start) / (count // 20) * 1e6)
    return FilterCost(states=len(prediction.states), advance=advance, step=step, reference=median(reference))


def step_times(
    filter_: CompiledFilter, first: Estimate, inputs: Vector, readings: Vector, count: int, rounds: int
) -> tuple[float, float]:
    """Return the medians over rounds of a compiled filter's step in place and on values [µs]."""
    advance: list[float] = []
    step: list[float] = []
    for _ in range(rounds):
        filter_.hold(first)
        filter_.inputs[:], filter_.readings[:] = inputs, readings
        start = perf_counter()
        for _ in range(count):
            filter_.advance()
        advance.append((perf_counter() - start) / count * 1e6)
        belief = first
        start = perf_counter()
        for _ in range(count):
            belief = filter_.step(belief, inputs, readings)
        step.append((perf_counter() - start) / count * 1e6)
    return median(advance), median(step)


def decentralised_cost(groups: int, *, suspension: bool = False, count: int = 2000, rounds: int = 9) -> float:
    """Return the processor's time of a step of the decentralised filter in place [µs], the median of rounds.

    A train of equal wheelsets that turn apart, two to a bogie, with readings that scatter as it expects.
    """
    masses = {f"m_wheelset[{i + 1}]": 15e3 for i in range(groups)}
    frames = {"m_frame": 3500.0, "I_frame": 2200.0, "wheelbase": 1.9}
    data = {"J": 120.0, "r_wheel": 0.46, "n_units": 2.0, "r_friction": 0.24} | masses
    if suspension:
        data |= frames | {f"wheelsets_per_bogie[{b + 1}]": 2.0 for b in range(groups // 2)}
    formation = Formation((1,) * groups)
    consist = consist_of(formation, data)
    noise = NOISE_SETS["train_service"]
    variances = noise.reading_noise(consist.outputs)
    filter_ = DecentralisedFilter(consist, noise.process_noise(consist.states), variances, 1e-3)
    mean = start_of(consist, formation, data, speed=30.0)
    held = np.append(np.full(groups, 2e5), 0.0)
    expected = consist.prediction.output(mean, held)
    random = np.random.default_rng(0)
    readings = expected + np.sqrt(variances) * random.standard_normal((count, variances.size))
    durations: list[float] = []
    for _ in range(rounds):
        filter_.start(mean, noise.start_covariance(consist.states))
        filter_.inputs[:] = held
        begin = process_time()
        for reading in readings:
            filter_.readings[:] = reading
            filter_.advance()
        durations.append((process_time() - begin) / count * 1e6)
    return median(durations)


@dataclass(frozen=True, slots=True, kw_only=True)
class StopCost:
    """What a stop costs with one engine.

    Attributes:
        simulated: Length of the stop [s].
        wall: From scenario to figures [s], median.
        cycle: Time of the processor per communication period of 1 ms, figures included [µs], median.
    """

    simulated: float
    wall: float
    cycle: float


def stop_costs(*overrides: str, rounds: int = 3) -> dict[Engine, StopCost]:
    """Run a stop of the library several times, the engines in turn, after one that compiles what has to be."""
    scenario = load(LIBRARY / "trapezoid.toml", overrides)
    simulated = run_stop(scenario).metrics.duration
    engines = Engine.PYTHON, Engine.COMPILED
    wall: dict[Engine, list[float]] = {engine: [] for engine in engines}
    cpu: dict[Engine, list[float]] = {engine: [] for engine in engines}
    for _ in range(rounds):
        for engine in engines:
            start, cpu_start = perf_counter(), process_time()
            run_stop(scenario, engine=engine)
            wall[engine].append(perf_counter() - start)
            cpu[engine].append(process_time() - cpu_start)
    return {
        engine: StopCost(
            simulated=simulated, wall=median(wall[engine]), cycle=median(cpu[engine]) / (simulated / 1e-3) * 1e6
        )
        for engine in engines
    }


def bare_cost(*overrides: str, rounds: int = 5) -> float:
    """Return the time of the processor per communication period of a stop of which only the distance is taken [µs]."""
    scenario = load(LIBRARY / "trapezoid.toml", overrides)
    samples = run_stop(scenario).metrics.duration / scenario.periods.communication
    durations: list[float] = []
    for _ in range(rounds):
        start = process_time()
        braking_distance(scenario)
        durations.append((process_time() - start) / samples * 1e6)
    return median(durations)


@dataclass(frozen=True, slots=True, kw_only=True)
class BuildCost:
    """A cold build of every recipe.

    Attributes:
        recipes: How many.
        wall: [s].
        cpu: Of this process, which translates, and the C compilers [s].
    """

    recipes: int
    wall: float
    cpu: float


def build_cost() -> BuildCost:
    """Build every recipe into an empty folder, with nothing in the user's cache."""
    from railgrip.fmus.build import build
    from railgrip.fmus.recipe import read_recipes

    names = list(read_recipes().recipes)
    with tempfile.TemporaryDirectory() as folder, _empty_cache(Path(folder) / "cache"):
        before = _processor()
        start = perf_counter()
        for _ in build(names, "native", Path(folder)):
            pass
        wall = perf_counter() - start
        cpu = _processor() - before
    return BuildCost(recipes=len(names), wall=wall, cpu=cpu)


@contextmanager
def _empty_cache(folder: Path) -> Generator[None]:
    """Let FMUs and C libraries be looked for and kept in a folder that has none."""
    before = os.environ.get(VARIABLE)
    os.environ[VARIABLE] = str(folder)
    try:
        yield
    finally:
        os.environ.pop(VARIABLE)
        if before is not None:
            os.environ[VARIABLE] = before


def _processor() -> float:
    """Return the time that this process and those it has waited for have spent on processors [s]."""
    own, others = resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN)
    return own.ru_utime + own.ru_stime + others.ru_utime + others.ru_stime


def machine() -> str:
    """Return processor, number of cores and load, without which times mean little."""
    name = "unknown processor"
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        models = [line.partition(":")[2].strip() for line in cpuinfo.read_text().splitlines() if "model name" in line]
        name = models[0] if models else name
    return f"{name}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}"
