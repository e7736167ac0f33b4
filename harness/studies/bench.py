"""Durations, as medians and ratios of alternating runs, in which a busy machine slows both sides equally."""

import os
import re
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Final

import numpy as np
import pandas
from numpy.typing import NDArray

from railgrip.base.cache import VARIABLE
from railgrip.base.names import ElementName
from railgrip.base.units import quantity
from railgrip.campaign.run import CampaignRun, run_campaigns
from railgrip.campaign.work import Work
from railgrip.campaign.workers import environment
from railgrip.controllers.observation import Observation
from railgrip.estimation.field_test.filtering import (
    PHYSICAL,
    TEST,
    cases,
    filter_of,
    follow,
    prediction,
    run,
    specification,
    task_of,
)
from railgrip.estimation.field_test.score import evaluate
from railgrip.estimation.models import of_class
from railgrip.estimation.motion import braking_of
from railgrip.estimation.run import by_name
from railgrip.estimation.spec import LIBRARY, estimate_of, load_specification, prediction_for, settings_for
from railgrip.estimators.belief import GaussianEstimate, Vector
from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.design import NOISE_SETS
from railgrip.estimators.ekf import ExtendedKalmanFilter
from railgrip.estimators.filters.decentralised import DecentralisedFilter
from railgrip.estimators.prediction import CasadiPrediction, FilterVariables
from railgrip.fmi import SteppedFmuPrediction
from railgrip.fmi.description import Description, describe
from railgrip.fmi.mapping import Binding, Port, bind
from railgrip.fmi.trials import seconds_in_c, seconds_of_fmpy, seconds_of_railgrip
from railgrip.fmus.build import build, build_class, fmu
from railgrip.fmus.recipe import read_recipes
from railgrip.report.frame import Frame
from railgrip.report.page import Page
from railgrip.report.table import ReportTable
from railgrip.scenario.campaign import Campaign, PlannedStop
from railgrip.scenario.load import load
from railgrip.simulate.assembly import assemble
from railgrip.simulate.loop.loop import Loop
from railgrip.simulate.named_models import prediction_description, prediction_model
from railgrip.simulate.run import braking_distance, run_stop
from railgrip.simulate.train_prediction import central_of, consist_of, start_of
from railgrip.simulate.user_parts import CustomParts
from railgrip.studies.study import Study
from railgrip.vehicle.formation import Formation

Row = tuple[str, str, str]
"""A measurement: its subject, the figure with its unit, and its target, if there is one."""


SHARE_OF_QUICK: Final = 0.01
"""Share of the repetitions that remain in the quick form."""


def part(count: int, share: float) -> int:
    """Return a share of a number of repetitions, at least one."""
    return max(1, round(share * count))


def microseconds(
    call: Callable[[], object],
    *,
    count: int = 1,
    rounds: int = 9,
    share: float = 1.0,
    clock: Callable[[], float] = perf_counter,
) -> float:
    """Return the time of a call that is made `count` times in a row [µs], the median over rounds; see `part`."""
    durations: list[float] = []
    count = part(count, share)
    for _ in range(part(rounds, share)):
        begin = clock()
        for _ in range(count):
            call()
        durations.append((clock() - begin) / count * 1e6)
    return median(durations)


def in_turn(calls: Mapping[str, Callable[[], float]], rounds: int) -> Frame:
    """Call functions in turn, and return a frame of their results with a row for each round."""
    return pandas.DataFrame([{name: call() for name, call in calls.items()} for _ in range(rounds)])


def machine() -> str:
    """Return processor, number of cores and load, which are required to interpret times."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text(encoding="utf-8").splitlines() if cpuinfo.exists() else []
    name = next((line.partition(":")[2].strip() for line in lines if "model name" in line), "unknown processor")
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    return f"{name}, {os.cpu_count()} cores{load}"


def steps_of(recipe: str, share: float) -> Iterator[Row]:
    """Yield the time of set + step of 1 ms + get of a recipe by each interface."""
    times = step_times(fmu(recipe), count=part(2000, share), rounds=part(9, share))
    yield f"{recipe}: set + step of 1 ms + get, ours", f"{times['ours'].median():.1f} µs", ""
    yield "  the same in a loop in C", f"{times['c'].median():.1f} µs", "10 µs"
    yield "  FMPy's FMU2Slave over ours", f"{(times['fmpy'] / times['ours']).median():.2f}", ""
    yield "  ours over C", f"{(times['ours'] / times['c']).median():.2f}", ""


def step_times(file: Path, *, period: float = 1e-3, count: int = 2000, rounds: int = 9) -> Frame:
    """Step an FMU by each interface in turn, repeatedly; return a column of times of a step for each of them [µs].

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
    last: dict[str, np.ndarray] = {}

    def time_of(way: str, seconds: Callable[..., tuple[float, np.ndarray]]) -> float:
        time, last[way] = seconds(description, binding, inputs, period=period, count=count)
        return time / count * 1e6

    ways = {"ours": seconds_of_railgrip, "fmpy": seconds_of_fmpy, "c": seconds_in_c}
    times = in_turn({way: partial(time_of, way, seconds) for way, seconds in ways.items()}, rounds)
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


def of_scenario(what: str, *overrides: str, share: float) -> Iterator[Row]:
    """Yield the time of a cycle of 1 ms in the library's trapezoid, alternately with a compiled law and one in Python.

    A first run compiles everything.
    """
    scenario = load(Path("trapezoid"), ["controller.kind=slip_two_state", *overrides])
    simulated = run_stop(scenario).metrics.duration
    cycles = simulated / scenario.periods.communication
    alone = PythonSlipControl()
    laws = {"compiled": CustomParts(), "Python": CustomParts(controller=alone)}

    def loop(law: CustomParts) -> float:
        with assemble(scenario, objects=law) as parts:
            return microseconds(parts.run, rounds=1, clock=process_time) / cycles

    cycle = in_turn({name: partial(loop, law) for name, law in laws.items()}, part(3, share)).median()
    with assemble(scenario, objects=laws["Python"]) as parts:
        observation = next(Loop(parts.parts).decisions())
        law = microseconds(lambda: alone.decide(observation), rounds=5, share=share)
    compiled, python = cycle["compiled"], cycle["Python"]
    figures = microseconds(lambda: run_stop(scenario), rounds=3, share=share, clock=process_time) / cycles
    bare = microseconds(lambda: braking_distance(scenario), rounds=5, share=share, clock=process_time) / cycles
    yield f"{what}{CYCLE}", f"{compiled:.1f} µs", ""
    yield "  with assembly and figures", f"{figures:.1f} µs", ""
    yield FASTER, f"{1e6 * scenario.periods.communication / figures:.0f}", ""
    yield "  with assembly, without a trace", f"{bare:.1f} µs", "10 µs"
    yield "  a cycle, the same law in Python", f"{python:.1f} µs", ""
    yield "  of that the law itself", f"{law:.1f} µs", ""
    yield "  law in Python over compiled, the law's own time apart", f"{(python - law) / compiled:.2f}", "1.5"


def of_predictions(share: float) -> Iterator[Row]:
    """Yield the time of a stop without a trace for each kind of filter, and interface of its FMU, in turn."""
    kinds = ("compiled", "fmu", "co_simulation", "python")
    changes = {kind: [f"estimator.kind={kind}"] for kind in kinds} | {
        "co_simulation": ["estimator.interface=co_simulation"]
    }
    pace = ["start.speed=20 km/h"] if share < 1.0 else []
    stops = {kind: partial(braking_distance, load(Path("trapezoid"), [*changes[kind], *pace])) for kind in kinds}
    for stop in stops.values():
        stop()  # compiles everything
    timed = {kind: partial(microseconds, stop, rounds=1, clock=process_time) for kind, stop in stops.items()}
    compiled, fmu, co_simulation, python = in_turn(timed, part(3, share)).median() / 1e6
    yield "a stop with the filter over compiled equations", f"{compiled:.2f} s", ""
    yield "  over the prediction FMU", f"{fmu:.2f} s", ""
    yield "  over the prediction FMU that integrates itself, Co-Simulation", f"{co_simulation:.2f} s", ""
    yield "  in numpy over the equations", f"{python:.2f} s", ""
    yield "  prediction FMU over compiled", f"{fmu / compiled:.2f}", "2.5"


def of_workers(share: float) -> Iterator[Row]:
    """Yield the speed-up of two processes over one.

    It is measured from the end of the first stop to that of the last, without the start of processes, which takes
    seconds.
    """
    count = 3 + part(21, share)
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


def of_consists(share: float) -> Iterator[Row]:
    """Yield step and build of trains of equal four-axle cars with bogie frames on primary suspension.

    Each axle has a brake; the build does not use the cache. The quick form has only the shortest train.
    """
    for cars in (1, 2, 4, 8, 16)[: part(5, share)]:
        with tempfile.TemporaryDirectory() as folder:
            # A name that was never built: the description string is part of what the cache looks up.
            source = Path(folder) / "Cars.mo"
            meaning = Path(folder).as_posix()
            text = f'block Cars "{meaning}"\n  extends RailBraking.Plants.Consist(cars={cars});\nend Cars;\n'
            source.write_text(text, encoding="utf-8")
            begin = perf_counter()
            description = describe(build_class("Cars", source, compiler="native").path)
            seconds = perf_counter() - begin
            step, states = plant_step(description, BRAKING, rounds=part(15, share)), len(description.states)
            what = f"train of {cars} four-axle cars, {states} states: step of 1 ms in a loop in C"
            yield what, f"{step:.1f} µs", "25 µs for four cars" if cars == 4 else ""
            yield "  build of its FMU", f"{seconds:.1f} s", "30 s for eight cars" if cars == 8 else ""


def of_recipes(share: float) -> Iterator[Row]:
    """Yield the cold build of every recipe: into an empty folder, with nothing in the user's cache."""
    names = list(read_recipes().recipes)
    names = names[: part(len(names), share)]
    with tempfile.TemporaryDirectory() as folder, environment({VARIABLE: f"{folder}/cache"}):
        before, start = _processor(), perf_counter()
        for _ in build(names, "native", Path(folder)):
            pass
        wall, processor = perf_counter() - start, _processor() - before
    yield f"cold build of {len(names)} FMUs", f"{wall:.1f} s ({processor:.1f} s of processor)", "10 s"


def _processor() -> float:
    """Return the CPU time of this process and of the children it has waited for [s]."""
    return sum(os.times()[:4])


def of_train(model: str, noise: str, target: str, share: float) -> Iterator[Row]:
    """Yield the time of a step of each filter of a braked train with consistent readings."""
    equations = prediction_model(model)
    prediction = CasadiPrediction(equations, {v.name: v.start for v in equations.parameters})
    noise_set = NOISE_SETS[noise]
    noises = noise_set.process_noise(prediction.states), noise_set.reading_noise(prediction.outputs)
    compiled = CompiledFilter(prediction, *noises, 1e-3)
    plain = ExtendedKalmanFilter(prediction, *noises, 1e-3)
    inputs = np.array([2e5, 1e5, 1e5, 2e5, 0.0])
    mean = np.array([v.start for v in equations.states])
    readings = prediction.output(mean, inputs)
    first = compiled.start(mean, noise_set.start_covariance(prediction.states))
    by_fmu = CompiledFilter(of_class(model).prediction({}), *noises, 1e-3)
    by_co_simulation = CompiledFilter(stepped_by_fmu(prediction, model, 1e-3), *noises, 1e-3)
    advance, fmu, co_simulation = (
        in_place(filter_, first, inputs, readings, count=2000, share=share)
        for filter_ in (compiled, by_fmu, by_co_simulation)
    )
    on_values = microseconds(lambda: compiled.step(first, inputs, readings), count=2000, share=share)
    reference = microseconds(lambda: plain.step(first, inputs, readings), count=100, share=share)
    what = f"compiled filter, {len(prediction.states)} states, a step in place as in the loop"
    yield what, f"{advance:.1f} µs", target
    yield "  by the prediction FMU", f"{fmu:.1f} µs", ""
    yield "  prediction FMU over compiled", f"{fmu / advance:.2f}", "2.5"
    yield "  by the prediction FMU that integrates itself, Co-Simulation", f"{co_simulation:.1f} µs", ""
    yield "  on values", f"{on_values:.1f} µs", ""
    yield "  filter in numpy over compiled", f"{reference / on_values:.0f}", ""


def stepped_by_fmu(variables: FilterVariables, model: str, period: float) -> SteppedFmuPrediction:
    """Return a prediction by Co-Simulation with the variables of another one, and default parameters."""
    description = prediction_description(model, None, "me_cs")
    return SteppedFmuPrediction(
        description, period=period, parameters={}, states=variables.states, inputs=variables.inputs,
        outputs=variables.outputs,
    ).open()  # fmt: skip


def in_place(
    filter_: CompiledFilter, first: GaussianEstimate, inputs: Vector, readings: Vector, *, count: int, share: float
) -> float:
    """Return the time of a compiled filter's step in place, as the loop uses it [µs]."""
    filter_.hold(first)
    filter_.inputs[:], filter_.readings[:] = inputs, readings
    return microseconds(filter_.advance, count=count, share=share)


def of_groups(groups: int, share: float) -> Iterator[Row]:
    """Yield the time of a step of the decentralised filter over uncoupled wheelsets, two in each bogie."""
    step, with_suspension = (decentralised_step(groups, share, suspension=has_frames) for has_frames in (False, True))
    what, target = f"decentralised filter, {groups} wheelsets that turn apart", "40 µs" if groups == 16 else ""
    yield what, f"{step:.1f} µs", target
    yield "  with suspension", f"{with_suspension:.1f} µs", ""


def decentralised_step(groups: int, share: float, *, suspension: bool) -> float:
    """Return the CPU time of a step of the decentralised filter in place [µs], the median of rounds.

    The train has equal, uncoupled wheelsets, two in each bogie, and readings with the assumed noise.
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
    mean = start_of(consist.states, formation, data, speed=30.0)
    inputs = np.append(np.full(groups, 2e5), 0.0)
    train = central_of(formation, data)
    central = CasadiPrediction(train.model, train.parameters)
    shown = central.output(start_of(central.states, formation, data, speed=30.0), inputs)
    expected = shown[[train.readings.index(name) for name in consist.outputs]]
    random, count = np.random.default_rng(0), part(2000, share)
    readings = expected + np.sqrt(variances) * random.standard_normal((count, variances.size))

    def filtered() -> None:
        filter_.start(mean, noise.start_covariance(consist.states))
        filter_.inputs[:] = inputs
        for reading in readings:
            filter_.readings[:] = reading
            filter_.advance()

    return microseconds(filtered, share=share, clock=process_time) / count


def of_rig(share: float) -> Iterator[Row]:
    """Yield the time of a step of the rig's filter from a braked start with readings that fit it."""
    period = 5e-3
    specification = load_specification(LIBRARY / "rig_own.toml")
    prediction, settings = prediction_for(specification), settings_for(specification, period)
    process = by_name("process", settings.process, prediction.states)
    readings = by_name("readings", settings.readings, prediction.outputs)
    filter_ = CompiledFilter(prediction, process, readings, period, settings.gate)
    mean = np.array([70.0, 33.0, 0.35, 0.05])
    first = filter_.start(mean, by_name("deviation", settings.start_deviation, prediction.states) ** 2)
    step = in_place(filter_, first, np.array([20e3]), mean[:2], count=20_000, share=share)
    yield "compiled filter of the roller rig, in place", f"{step:.1f} µs", "3 µs"


def of_recording(share: float) -> Iterator[Row]:
    """Yield the computing times of the field test; a value of the tuning is for five copies of its mean length."""
    field_run, spec, model = run((TEST, cases()[TEST])), specification(), prediction()
    course = spec.course
    assert course is not None
    task = task_of(field_run.braking, model)
    filter_ = filter_of(model, task.data.period)
    recording, samples = braking_of(field_run.recording, course).recording, len(task.data.readings)
    step = microseconds(lambda: follow(task, filter_, PHYSICAL), share=share) / samples
    duration = microseconds(lambda: estimate_of(spec, recording), share=share) / 1e3
    track = microseconds(lambda: braking_of(field_run.recording, course), rounds=2, share=share) / 1e6
    value = microseconds(lambda: evaluate("consistent", [task] * 5, filter_, PHYSICAL), share=share) / 1e6
    yield f"13-state filter over a recording of {samples} samples, a sample", f"{step:.1f} µs", "5 µs"
    yield "  estimate of that recording", f"{duration:.0f} ms", ""
    yield "  track and track force from the run before", f"{track:.1f} s", ""
    yield "tuning: a value over five brakings, one core", f"{1e3 * value:.0f} ms", ""
    yield "  both objectives, 2 · 48 · 61 values", f"{2 * 48 * 61 * value / 60:.1f} min", "30 min"


CASES: Final[Mapping[str, Callable[..., Iterator[Row]]]] = {
    "cold build of all FMUs": of_recipes,
    **{f"steps of {name}": partial(steps_of, name) for name in ("TwoPartTrain", "TwoPartTrainPneumatic")},
    "trains of 1 to 16 cars": of_consists,
    "filter over TrainPrediction": partial(of_train, "TrainPrediction", "train_ideal", "15 µs"),
    "filter over TrainPredictionReduced": partial(of_train, "TrainPredictionReduced", "reduced_ideal", "5 µs"),
    **{f"decentralised filter, {groups} groups": partial(of_groups, groups) for groups in (4, 8, 16, 32)},
    "filter of the roller rig": of_rig,
    "filter of the field test over a recording": of_recording,
    f"whole stops, {ABC}": partial(of_scenario, ABC),
    "whole stops, slip-based control": partial(
        of_scenario, "slip-based control", "controller.kind=slip_two_state", "estimator.kind=none"
    ),
    "stops by what the filter evaluates": of_predictions,
    "stops in two processes": of_workers,
}
"""Activity → its rows, which a share of the repetitions gives."""


@dataclass(frozen=True)
class BenchStudy(Study, quick="one case of each kind, with 1 % of the repetitions"):
    """Measure durations, as medians and ratios of cases that run in turn.

    The page lists those that exceed their targets, which is not an error. Run it on an idle machine.
    """

    has_cases = False

    def page(self, work: Work) -> Page:
        """Measure one case after the other, in this process, and return the table.

        The quick form has one case of each kind, with few repetitions.
        """
        first = {getattr(case, "func", case): (doing, case) for doing, case in reversed([*CASES.items()])}
        rows: list[Row] = []
        for doing, case in reversed(first.values()) if self.quick else CASES.items():
            work.notify(doing)
            rows += case(share=SHARE_OF_QUICK if self.quick else 1.0)
        table = ReportTable.of(("what", "measured", "target"), rows, title=machine())
        return Page(
            title="Durations",
            question="How long do the parts of a stop take, and how do their durations compare?",
            answer=answer(rows),
            template="studies/bench.md.jinja",
            values={"machine": machine(), "durations": table},
            tables={"durations.csv": table},
            screen=(table,),
        )


def answer(rows: Sequence[Row]) -> str:
    """Return the time of a cycle, the speed of a stop relative to real time, and the times that exceed their target."""
    measured = {what: figure for what, figure, _ in reversed(rows)}  # of rows with one name, the first
    cycle, faster = measured[f"{ABC}{CYCLE}"], measured[FASTER]
    judged, over, head = 0, list[str](), ""
    for what, figure, target in rows:
        head = head if what.startswith(" ") else what
        judged += bool(target)
        if target and _is_over(figure, target):
            name = head if what == head else f"{head} – {what.strip()}"
            over.append(f"{name}: {figure}, target {target}")
    verdict = f"{len(over)} over target: {'; '.join(over)}" if over else "none is over it"
    return (
        f"With {ABC} and a compiled law, a cycle of the loop takes {cycle}, and a stop with assembly and "
        f"figures runs {faster} times faster than real time. Of {judged} durations and ratios with a target, {verdict}."
    )


def _is_over(figure: str, target: str) -> bool:
    limit = target.removeprefix(AT_LEAST)
    sizes: list[float] = []
    for text in (figure, limit):
        match = re.match(r"-?[\d.]+( ([µm]?s|min)\b)?", text)
        assert match is not None, text
        number, unit = quantity(match[0])
        sizes.append(unit.factor * number)
    return sizes[0] > sizes[1] if limit == target else sizes[0] < sizes[1]


STUDY = BenchStudy
