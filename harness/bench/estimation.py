"""What estimating costs: the field test's filter over a recording, `estimate` of one, a value of the tuning."""

from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from time import perf_counter

from railgrip.estimation.course import with_track_force
from railgrip.estimation.spec import estimate_of
from railgrip.studies.field_test.filtering import filter_of, follow, prediction, specification, task_of
from railgrip.studies.field_test.noise import PHYSICAL
from railgrip.studies.field_test.objective import evaluate
from railgrip.studies.field_test.runs import TEST
from railgrip.studies.field_test.runs import cases as field_test
from railgrip.studies.field_test.runs import run as run_case


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimationCost:
    """Medians over rounds.

    Attributes:
        samples: Of the recording, from coasting to the stop.
        step: Of the 13-state filter over all of them in one call, with what it tells of each [µs a sample].
        estimate: Of the same recording as `railgrip estimate` runs it, its filter found compiled [s].
        course: Of recovering track and track force from the whole run before [s].
        evaluation: Of one value of the tuning's objective, over the five brakings, on one core [s].
    """

    samples: int
    step: float
    estimate: float
    course: float
    evaluation: float


def _seconds(call: Callable[[], object]) -> float:
    start = perf_counter()
    call()
    return perf_counter() - start


def estimation_cost(cases: int = 5, rounds: int = 9) -> EstimationCost:
    """Run each over the test case of the field test, again and again.

    Args:
        cases: Brakings of an evaluation; copies of the one, which is of their mean length.
    """
    run = run_case(field_test()[TEST], TEST)
    spec, model = specification(), prediction()
    course = spec.course
    assert course is not None
    task = task_of(run.braking, model)
    filter_ = filter_of(model, task.period)
    recording = with_track_force(run.recording, course)
    times: dict[str, list[float]] = {"step": [], "estimate": [], "course": [], "evaluation": []}
    for round_ in range(rounds):
        times["step"].append(_seconds(lambda: follow(task, filter_, PHYSICAL)) / len(task.readings) * 1e6)
        times["estimate"].append(_seconds(lambda: estimate_of(spec, recording)))
        if round_ < 2:
            times["course"].append(_seconds(lambda: with_track_force(run.recording, course)))
        times["evaluation"].append(_seconds(lambda: evaluate("consistent", [task] * cases, filter_, PHYSICAL)))
    return EstimationCost(
        samples=len(task.readings),
        step=median(times["step"]),
        estimate=median(times["estimate"]),
        course=median(times["course"]),
        evaluation=median(times["evaluation"]),
    )
