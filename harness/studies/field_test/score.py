"""How near the truth the filter came, and how near its sensors the track."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from railgrip.campaign.work import Work
from railgrip.errors import EstimationError
from railgrip.estimators.belief import Array
from railgrip.estimators.compiled import CompiledFilter, Estimates
from railgrip.scenario.schema import Scenario
from railgrip.studies.field_test.filtering import Task, filter_of, follow, prediction, task_of
from railgrip.studies.field_test.noise import GROUPS, Noise
from railgrip.studies.field_test.objective import terms_of
from railgrip.studies.field_test.runs import TEST, Run, run
from railgrip.trace.samples import reading_of, truth_of

SETTLED = 1.0
"""After the brake is applied, what the filter needs to settle [s]; the paper shows the same oscillation."""


Figures = dict[str, Any]
"""Errors by name."""


def score(task: Task, estimate: Estimates) -> Figures:
    """Return the errors of a filter over a braking, from a second after the brake is applied; estimate minus truth.

    `deviation`, `nis` and `nees` as `terms_of`; RMSE of `speed` [m/s], of `adhesion` and `pad_friction` over all groups
    and `…_of` each, and of `mean_pad_friction`, weighted by what each group brakes with, which is what the train feels;
    `…_constant` is that of the best constant, known only afterwards: what a filter must be better than. `distance` is
    the error of the braking distance, from the estimated speed, relative.

    Raises:
        EstimationError: The truth is not known.
    """
    if task.truth is None:
        raise EstimationError(f"{task.braking.name}: its truth is not known; only simulated trains tell.")
    terms = terms_of(task, estimate)
    after = slice(task.braking.brake + round(SETTLED / task.period), None)
    of_pads, of_adhesions = slice(1 + GROUPS, 1 + 2 * GROUPS), slice(1 + 2 * GROUPS, None)
    error, truth = (estimate.mean - task.truth)[after], task.truth[after]
    pads, adhesions = error[:, of_pads], error[:, of_adhesions]
    # Torque at the same μ_B: units times radius times pressure.
    share = np.array([3 * 0.235, 2 * 0.22, 2 * 0.22, 3 * 0.235]) * task.inputs[after, :GROUPS]
    share /= share.sum(axis=1, keepdims=True)
    braking = slice(task.braking.brake, None)
    true_way = float(task.truth[braking, 0].sum())
    return {
        "deviation": terms.deviation, "nis": terms.nis, "nees": terms.nees,
        "speed": _rms(error[:, 0]),
        "distance": float(estimate.mean[braking, 0].sum()) / true_way - 1.0,
        "adhesion": _rms(adhesions),
        "adhesion_of": np.sqrt((adhesions**2).mean(axis=0)),
        "pad_friction": _rms(pads),
        "pad_friction_of": np.sqrt((pads**2).mean(axis=0)),
        "mean_pad_friction": _rms((pads * share).sum(axis=1)),
        "adhesion_constant": float(np.std(truth[:, of_adhesions])),
        "pad_friction_constant": float(np.std(truth[:, of_pads])),
        "mean_pad_friction_constant": float(np.std((truth[:, of_pads] * share).sum(axis=1))),
    }  # fmt: skip


def track_score(run: Run) -> Figures:
    """Return the errors of the track recovered from a run.

    `distance` at the end of the run, relative; RMSE of `curvature` [1/m], of `slope`, and of `force` in braking [N].

    Raises:
        EstimationError: The truth is not known.
    """
    motion, recording = run.braking.motion, run.braking.recording
    course = motion.course
    slope, curvature = run.laid(course.distance)
    force = reading_of(recording, "track_force") - truth_of(recording, "track_force")
    return {
        "distance": float(motion.distance[-1] / truth_of(run.recording, "distance")[-1]) - 1.0,
        "curvature": _rms(course.curvature - curvature), "slope": _rms(course.slope - slope), "force": _rms(force),
    }  # fmt: skip


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


SEEDS = tuple(range(1, 13))


def over_seeds(
    scenario: Scenario, noises: Mapping[str, Noise], work: Work, import_from: Sequence[Path] = ()
) -> tuple[list[Figures], dict[str, list[Figures]]]:
    """Return the errors in case 6 with sensors of every seed, in the order of `SEEDS`.

    Of what was recovered of the track, and of the filter, by the title of its noises; `import_from` as for `run`.

    Raises:
        EstimationError: See `railgrip.studies.field_test.runs.run`.
    """
    scenarios = [scenario.model_copy(update={"seed": seed}) for seed in SEEDS]
    rows = work.map(partial(case_6, noises=noises, import_from=tuple(import_from)), scenarios, keep=not import_from)
    return [track for track, _ in rows], {title: [scores[title] for _, scores in rows] for title in noises}


def case_6(
    scenario: Scenario, noises: Mapping[str, Noise], import_from: Sequence[Path] = ()
) -> tuple[Figures, dict[str, Figures]]:
    """Return the errors of a run: of its track, and of the filter by the title of its noises."""
    model, field_run = prediction(), run((TEST, scenario), import_from)
    task = task_of(field_run.braking, model)
    filter_ = filter_of(model, task.period)
    return track_score(field_run), {title: score(task, follow(task, filter_, noise)) for title, noise in noises.items()}


COMMON = 10.0 ** np.arange(-4, 5, 1.0)
TRUSTED = 10.0 ** np.arange(-8, 3, 1.0)


Sweep = dict[str, Array]
"""Figures over brakings for each `factor`: worst `deviation`, means of `adhesion`, `pad_friction` and `nees`."""


def common_factor(tasks: Sequence[Task], filter_: CompiledFilter, noise: Noise) -> Sweep:
    """Return what a factor on R, Q and the first covariance does: nothing to the mean, everything to its spread."""
    return _sweep(tasks, filter_, COMMON, lambda f: (noise.scaled(f, f), f))


def readings_trusted(tasks: Sequence[Task], filter_: CompiledFilter, noise: Noise) -> Sweep:
    """Return what a factor on R alone does: towards zero the filter repeats its readings, and (14) goes to zero."""
    return _sweep(tasks, filter_, TRUSTED, lambda f: (noise.scaled(f, 1.0), 1.0))


def _sweep(
    tasks: Sequence[Task],
    filter_: CompiledFilter,
    factors: Array,
    setting: Callable[[float], tuple[Noise, float]],
) -> Sweep:
    rows: list[dict[str, float]] = []
    for factor in factors:
        noise, start = setting(float(factor))
        scores = [score(task, follow(task, filter_, noise, start)) for task in tasks]
        means = {name: float(np.mean([s[name] for s in scores])) for name in ("adhesion", "pad_friction", "nees")}
        rows.append({"factor": float(factor), "deviation": max(s["deviation"] for s in scores)} | means)
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}
