"""Computing time of filters: one step of each, and the field test's filter in `estimate` and in tuning."""

from collections.abc import Iterator
from time import process_time

import numpy as np

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
from railgrip.simulate.named_models import compile_class, prediction_description
from railgrip.simulate.train_prediction import central_of, consist_of, start_of
from railgrip.studies.bench import Row, microseconds
from railgrip.studies.field_test.filtering import (
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
from railgrip.studies.field_test.score import evaluate
from railgrip.vehicle.formation import Formation


def of_train(model: str, noise: str, target: str) -> Iterator[Row]:
    """Yield the time of a step of each filter of a braked train with consistent readings."""
    translation = compile_class(f"RailBraking.Predictions.{model}")
    prediction = CasadiPrediction(translation, {v.name: v.start for v in translation.parameters})
    noise_set = NOISE_SETS[noise]
    noises = noise_set.process_noise(prediction.states), noise_set.reading_noise(prediction.outputs)
    compiled = CompiledFilter(prediction, *noises, 1e-3)
    plain = ExtendedKalmanFilter(prediction, *noises, 1e-3)
    inputs = np.array([2e5, 1e5, 1e5, 2e5, 0.0])
    mean = np.array([v.start for v in translation.states])
    readings = prediction.output(mean, inputs)
    first = compiled.start(mean, noise_set.start_covariance(prediction.states))
    advance = in_place(compiled, first, inputs, readings, count=2000)
    on_values = microseconds(lambda: compiled.step(first, inputs, readings), count=2000)
    reference = microseconds(lambda: plain.step(first, inputs, readings), count=100)
    what = f"compiled filter, {len(prediction.states)} states, a step in place as in the loop"
    by_fmu = of_class(model).prediction({})
    stepped = CompiledFilter(by_fmu, *noises, 1e-3)
    fmu = in_place(stepped, first, inputs, readings, count=2000)
    yield what, f"{advance:.1f} µs", target
    yield "  by the prediction FMU", f"{fmu:.1f} µs", ""
    yield "  prediction FMU over compiled", f"{fmu / advance:.2f}", "2.5"
    itself = stepped_by_fmu(prediction, model, 1e-3)
    by_co_simulation = in_place(CompiledFilter(itself, *noises, 1e-3), first, inputs, readings, count=2000)
    yield "  by the prediction FMU that integrates itself, Co-Simulation", f"{by_co_simulation:.1f} µs", ""
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
    filter_: CompiledFilter, first: GaussianEstimate, inputs: Vector, readings: Vector, *, count: int, rounds: int = 9
) -> float:
    """Return the time of a compiled filter's step in place, as the loop uses it [µs]."""
    filter_.hold(first)
    filter_.inputs[:], filter_.readings[:] = inputs, readings
    return microseconds(filter_.advance, count=count, rounds=rounds)


def of_groups(groups: int) -> Iterator[Row]:
    """Yield the time of a step of the decentralised filter over uncoupled wheelsets, two in each bogie."""
    target = "40 µs" if groups == 16 else ""
    yield f"decentralised filter, {groups} wheelsets that turn apart", f"{decentralised_step(groups):.1f} µs", target
    yield "  with suspension", f"{decentralised_step(groups, suspension=True):.1f} µs", ""


def decentralised_step(groups: int, *, suspension: bool = False, count: int = 2000, rounds: int = 9) -> float:
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
    random = np.random.default_rng(0)
    readings = expected + np.sqrt(variances) * random.standard_normal((count, variances.size))

    def filtered() -> None:
        filter_.start(mean, noise.start_covariance(consist.states))
        filter_.inputs[:] = inputs
        for reading in readings:
            filter_.readings[:] = reading
            filter_.advance()

    return microseconds(filtered, rounds=rounds, clock=process_time) / count


def of_rig() -> Iterator[Row]:
    """Yield a step of the compiled filter of the roller rig."""
    yield "compiled filter of the roller rig, in place", f"{rig_step():.1f} µs", "3 µs"


def rig_step(*, count: int = 20_000, rounds: int = 7, period: float = 5e-3) -> float:
    """Return the time of a step of the rig's filter from a braked start with readings that fit it [µs]."""
    specification = load_specification(LIBRARY / "rig_own.toml")
    prediction, settings = prediction_for(specification), settings_for(specification, period)
    process = by_name("process", settings.process, prediction.states)
    readings = by_name("readings", settings.readings, prediction.outputs)
    filter_ = CompiledFilter(prediction, process, readings, period, settings.gate)
    mean = np.array([70.0, 33.0, 0.35, 0.05])
    first = filter_.start(mean, by_name("deviation", settings.start_deviation, prediction.states) ** 2)
    return in_place(filter_, first, np.array([20e3]), mean[:2], count=count, rounds=rounds)


def of_recording() -> Iterator[Row]:
    """Yield the computing times of the field test; a value of the tuning is for five copies of its mean length."""
    field_run, spec, model = run((TEST, cases()[TEST])), specification(), prediction()
    course = spec.course
    assert course is not None
    task = task_of(field_run.braking, model)
    filter_ = filter_of(model, task.data.period)
    recording, samples = braking_of(field_run.recording, course).recording, len(task.data.readings)
    step = microseconds(lambda: follow(task, filter_, PHYSICAL)) / samples
    duration = microseconds(lambda: estimate_of(spec, recording)) / 1e3
    track = microseconds(lambda: braking_of(field_run.recording, course), rounds=2) / 1e6
    value = microseconds(lambda: evaluate("consistent", [task] * 5, filter_, PHYSICAL)) / 1e6
    yield f"13-state filter over a recording of {samples} samples, a sample", f"{step:.1f} µs", "5 µs"
    yield "  estimate of that recording", f"{duration:.0f} ms", ""
    yield "  track and track force from the run before", f"{track:.1f} s", ""
    yield "tuning: a value over five brakings, one core", f"{1e3 * value:.0f} ms", ""
    yield "  both objectives, 2 · 48 · 61 values", f"{2 * 48 * 61 * value / 60:.1f} min", "30 min"
