"""Errors of the filter against true values, of the recovered track, and the search for the noises of equation (13).

The search is differential evolution, in stages that are stored. Its objective is equation (14) of the paper, or the
same with terms for consistency. A stage is a few generations from the population of the last one, with separate random
numbers: an interrupted search resumes after its last complete stage and ends with the result of an uninterrupted one.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from threading import local as thread_local
from typing import Literal

import numpy as np
from scipy.optimize import differential_evolution
from scipy.stats import qmc

from railgrip.base.errors import EstimationError, FilterDiverged
from railgrip.estimation.field_test.filtering import (
    GROUPS,
    NAMES,
    PHYSICAL,
    FieldRun,
    FilterTask,
    Noise,
    equations,
    filter_of,
    follow,
)
from railgrip.estimation.judgement import rms
from railgrip.estimators.belief import Array
from railgrip.estimators.compiled import CompiledFilter, FilterRecord
from railgrip.recording.samples import reading_of, truth_of

R_WHEEL = 0.38
"""Weight of |Δω| against |Δv| [m]: rim speeds count like the speed of the train."""

FRICTION = slice(1 + GROUPS, 1 + 3 * GROUPS)
"""μ_B and α among the states."""


@dataclass(frozen=True, slots=True)
class Terms:
    """Terms of the objectives of tuning for one braking.

    Attributes:
        deviation: O_c of equation (14): mean of Σ r|ω measured − ω observed| + |v measured − v observed| [m/s].
        surprise: The same for the predicted readings, |ω measured − ω predicted| … [m/s]; unlike O_c, a filter cannot
            reduce it by repeating its readings.
        nis: Mean normalised innovation squared over its degrees, 1 for a consistent filter.
        nees: Mean of (error/sd)² over μ_B (brakes applied) and α, 1 for a consistent filter; NaN without truth.
    """

    deviation: float
    surprise: float
    nis: float
    nees: float


def terms_of(task: FilterTask, estimate: FilterRecord) -> Terms:
    """Return the terms of one braking."""
    apart, ahead = (
        np.abs(task.data.readings - prediction).mean(axis=0)
        for prediction in (estimate.mean[:, : 1 + GROUPS], estimate.expectation)
    )
    nees = np.nan
    if task.truth is not None:
        # Before the brake is applied pad friction is held constant.
        after = slice(task.braking.brake + round(1.0 / task.data.period), None)
        error = (estimate.mean - task.truth)[after, FRICTION]
        nees = float(np.mean(error**2 / estimate.variance[after, FRICTION]))
    return Terms(
        deviation=float(apart[0] + R_WHEEL * apart[1:].sum()),
        surprise=float(ahead[0] + R_WHEEL * ahead[1:].sum()),
        nis=float(estimate.squared_innovation.sum() / estimate.degrees.sum()),
        nees=nees,
    )


SETTLED = 1.0
"""Time that the filter needs to settle after the brake is applied [s]; the paper shows the same oscillation."""


Figures = dict[str, float]
"""Errors by name."""


def score(task: FilterTask, estimate: FilterRecord) -> Figures:
    """Return the errors of a filter over a braking, from a second after the brake is applied; estimate minus truth.

    `deviation`, `nis` and `nees` as `terms_of`; RMSE of `speed` [m/s], of `adhesion` and `pad_friction` over all
    groups, and of `mean_pad_friction`, weighted by the braking torque of each group. `…_constant` is the RMSE
    of the best constant, known only afterwards; a useful filter is better. `distance` is the relative error of the
    braking distance by the estimated speed.

    Raises:
        EstimationError: The recording has no truth.
    """
    if task.truth is None:
        name = task.braking.recording.attrs.get("name", "")
        raise EstimationError(f"{name}: it has no true values to compare with; simulate the run.")
    terms = terms_of(task, estimate)
    after = slice(task.braking.brake + round(SETTLED / task.data.period), None)
    of_pads, of_adhesions = slice(1 + GROUPS, 1 + 2 * GROUPS), slice(1 + 2 * GROUPS, None)
    error, truth = (estimate.mean - task.truth)[after], task.truth[after]
    pads, adhesions = error[:, of_pads], error[:, of_adhesions]
    # Torque at the same μ_B: units times radius times pressure.
    share = np.array([3 * 0.235, 2 * 0.22, 2 * 0.22, 3 * 0.235]) * task.data.inputs[after, :GROUPS]
    share /= share.sum(axis=1, keepdims=True)
    braking = slice(task.braking.brake, None)
    true_distance = float(task.truth[braking, 0].sum())
    return {
        "deviation": terms.deviation, "nis": terms.nis, "nees": terms.nees,
        "speed": rms(error[:, 0]),
        "distance": float(estimate.mean[braking, 0].sum()) / true_distance - 1.0,
        "adhesion": rms(adhesions),
        "pad_friction": rms(pads),
        "mean_pad_friction": rms((pads * share).sum(axis=1)),
        "adhesion_constant": float(np.std(truth[:, of_adhesions])),
        "pad_friction_constant": float(np.std(truth[:, of_pads])),
        "mean_pad_friction_constant": float(np.std((truth[:, of_pads] * share).sum(axis=1))),
    }  # fmt: skip


def track_score(run: FieldRun) -> Figures:
    """Return the errors of the track recovered from a run.

    `distance` at the end of the run, relative; RMSE of `curvature` [1/m], of `slope`, and of `force` in braking [N].

    Raises:
        EstimationError: The recording has no truth.
    """
    motion, recording = run.braking.motion, run.braking.recording
    course = motion.course
    slope, curvature = run.plan_geometry(course.distance)
    force = reading_of(recording, "track_force") - truth_of(recording, "track_force")
    return {
        "distance": float(motion.distance[-1] / truth_of(run.recording, "distance")[-1]) - 1.0,
        "curvature": rms(course.curvature - curvature), "slope": rms(course.slope - slope), "force": rms(force),
    }  # fmt: skip


BOUNDS: dict[str, tuple[float, float]] = {
    "R_v": (-8.0, 0.0),
    "R_w": (-8.0, 0.0),
    "Q_v": (-10.0, 0.0),
    "Q_w": (-8.0, 1.0),
    "Q_mu_b": (-8.0, -1.0),
    "Q_alpha": (-6.0, 1.0),
}
"""Bounds, decadic logarithms: the usual range of such filters (1e-9 to 1e1), limited to values of real sensors."""


Kind = Literal["paper", "consistent"]

DIVERGED = 1e3
"""Value of noises with which the filter diverges; all others are below."""

WEIGHT = 0.02
"""Cost of a factor of ten in NIS or NEES [m/s]: about half of the surprise due to noise of the sensors, so that neither
term dominates."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """Size and seed of a search.

    Attributes:
        population: Number of candidates.
        stage: Generations in a stage.
    """

    population: int
    generations: int
    stage: int
    seed: int


Generations = tuple[Array, float, list[float]]
"""Population after some generations, the best first, the value of the best, and the best after each generation."""


def tune(
    kind: Kind,
    tasks: Sequence[FilterTask],
    search: Search,
    threads: int,
    run_stage: Callable[[Callable[[], Generations]], Generations] = lambda stage: stage(),
) -> tuple[Noise, float, list[float]]:
    """Return the noises that minimise an objective over brakings, its value, and the best after each generation.

    Args:
        kind: See `value`.
        tasks: Brakings.
        search: Size and seed of the search.
        threads: Number of threads that evaluate candidates.
        run_stage: Function that runs a stage, or returns its stored result.

    Raises:
        EstimationError: The brakings have different periods.
    """
    periods = {task.data.period for task in tasks}
    if len(periods) != 1:
        raise EstimationError(f"tuning needs brakings of one period, got {sorted(periods)} s; resample them.")
    population, history, lowest = _first(search), list[float](), np.inf
    while len(history) < search.generations:
        generations, draws = min(search.stage, search.generations - len(history)), (search.seed, len(history))
        stage = partial(_evolve, kind, tasks, population, generations, draws, threads)
        population, lowest, best_of_each = run_stage(stage)
        history += best_of_each
        if not best_of_each:
            break
    return Noise.of(population[0]), lowest, history


def _evolve(
    kind: Kind, tasks: Sequence[FilterTask], population: Array, generations: int, draws: tuple[int, int], threads: int
) -> Generations:
    """Return the population after a stage, the best first, its value, and the best after each generation.

    Args:
        kind: `paper` for equation (14), `consistent` to weigh NIS and NEES too.
        tasks: Brakings, all of one period.
        population: Population at the beginning.
        generations: Number of generations in the stage.
        draws: Seed of the search, and generations before this stage.
        threads: Number of threads that evaluate candidates.
    """
    period, model, mine = tasks[0].data.period, equations(), thread_local()
    history: list[float] = []

    def objective(logarithms: Array) -> float:
        # Each thread has its own filter; the C code runs without Python's lock, so threads are sufficient.
        if not hasattr(mine, "filter"):
            mine.filter = filter_of(model, period)
        return evaluate(kind, tasks, mine.filter, Noise.of(logarithms))

    def note(intermediate_result: object) -> None:
        history.append(float(intermediate_result.fun))  # pyright: ignore[reportAttributeAccessIssue]

    filter_of(model, period)  # compiled once here, not by every thread
    with ThreadPoolExecutor(threads) as pool:
        optimum = differential_evolution(
            objective,
            limits(),
            init=population,  # pyright: ignore[reportArgumentType] - the stubs know names only
            maxiter=generations,
            rng=np.random.default_rng(draws),
            strategy="best1bin",
            mutation=(0.4, 0.9),
            recombination=0.8,
            updating="deferred",
            workers=pool.map,  # pyright: ignore[reportArgumentType] - needs no keyword of map
            polish=False,
            # All generations are run; the history shows an early convergence.
            tol=0.0,
            callback=note,
        )
    order = np.argsort(optimum.population_energies, kind="stable")
    return optimum.population[order], float(optimum.fun), history


def limits() -> list[tuple[float, float]]:
    """Return the bounds of the search, decadic logarithms, in the order of `NAMES`."""
    return [BOUNDS.get(name, BOUNDS[name.rstrip("1234")]) for name in NAMES]


def _first(search: Search) -> Array:
    # `PHYSICAL` is in the first population, so the search cannot end with worse noises.
    bounds = np.array(limits()).T
    sample = qmc.LatinHypercube(len(NAMES), rng=np.random.default_rng(search.seed)).random(search.population)
    population = qmc.scale(sample, *bounds)
    population[0] = np.clip(PHYSICAL.logarithms, *bounds)
    return population


def value(kind: Kind, terms: Sequence[Terms]) -> float:
    """Return the worst case: of the deviations, or of the surprises plus the distance of NIS and NEES from 1.

    Raises:
        EstimationError: The objective is consistency, but a recording has no truth.
    """
    if kind == "paper":
        return max(term.deviation for term in terms)
    if any(np.isnan(term.nees) for term in terms):
        raise EstimationError("tuning for consistency needs recordings with truth; tune for 'paper'.")
    return max(term.surprise + WEIGHT * (abs(np.log10(term.nis)) + abs(np.log10(term.nees))) for term in terms)


def evaluate(kind: Kind, tasks: Sequence[FilterTask], filter_: CompiledFilter, noise: Noise) -> float:
    """Return the objective of noises over brakings."""
    try:
        return value(kind, [terms_of(task, follow(task, filter_, noise)) for task in tasks])
    except FilterDiverged:
        return DIVERGED
