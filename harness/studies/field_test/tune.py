"""Search for the twelve noises of equation (13) by differential evolution, in stages that are stored.

The objective is equation (14) of the paper, or the same with terms for consistency. A stage is a few generations from
the population of the last one, with separate random numbers: an interrupted search resumes after its last complete
stage and ends with the result of an uninterrupted one.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from threading import local as thread_local
from typing import Literal

import numpy as np
from scipy.optimize import differential_evolution
from scipy.stats import qmc

from railgrip.base.errors import EstimationError, FilterDiverged
from railgrip.campaign.work import Work, call
from railgrip.estimators.belief import Array
from railgrip.estimators.compiled import CompiledFilter
from railgrip.studies.field_test.filtering import NAMES, PHYSICAL, FilterTask, Noise, equations, filter_of, follow
from railgrip.studies.field_test.score import Terms, terms_of

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


def tune(kind: Kind, tasks: Sequence[FilterTask], search: Search, work: Work) -> tuple[Noise, float, list[float]]:
    """Return the noises that minimise an objective over brakings, its value, and the best after each generation.

    Raises:
        EstimationError: The brakings have different periods.
    """
    periods = {task.data.period for task in tasks}
    if len(periods) != 1:
        raise EstimationError(f"tuning needs brakings of one period, got {sorted(periods)} s; resample them.")
    population, history, lowest = _first(search), list[float](), np.inf
    while len(history) < search.generations:
        generations, draws = min(search.stage, search.generations - len(history)), (search.seed, len(history))
        stage = partial(_evolve, kind, tasks, population, generations, draws, work.count)
        ((population, lowest, best_of_each),) = work.map(call, [stage])
        history += best_of_each
        work.notify(f"generation {len(history)}, best {lowest:.6f} m/s")
        if not best_of_each:
            break
    return Noise.of(population[0]), lowest, history


def _evolve(
    kind: Kind, tasks: Sequence[FilterTask], population: Array, generations: int, draws: tuple[int, int], threads: int
) -> tuple[Array, float, list[float]]:
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
