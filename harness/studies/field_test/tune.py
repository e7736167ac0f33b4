"""Finding the twelve noises of equation (13): differential evolution, in stages that are kept.

A stage is a few generations from the population that the last one left, with random numbers of its own: a search that
was interrupted goes on from the last whole stage and ends as one that was not.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from threading import local as thread_local

import numpy as np
from scipy.optimize import differential_evolution
from scipy.stats import qmc

from railgrip.campaign.work import Work
from railgrip.errors import EstimationError
from railgrip.estimators.belief import Array
from railgrip.studies.field_test.filtering import Task, equations, filter_of
from railgrip.studies.field_test.noise import NAMES, PHYSICAL, Noise
from railgrip.studies.field_test.objective import Kind, evaluate

BOUNDS: dict[str, tuple[float, float]] = {
    "R_v": (-8.0, 0.0),
    "R_w": (-8.0, 0.0),
    "Q_v": (-10.0, 0.0),
    "Q_w": (-8.0, 1.0),
    "Q_mu_b": (-8.0, -1.0),
    "Q_alpha": (-6.0, 1.0),
}
"""Decadic logarithms; the range that such filters are tuned in (1e-9 to 1e1), less what no sensor of a train can be."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """How long to search, and from which random numbers.

    Attributes:
        population: Candidates.
        stage: Generations in a stage.
    """

    population: int
    generations: int
    stage: int
    seed: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """A part of a search.

    Attributes:
        kind: `paper` for equation (14), `consistent` to weigh NIS and NEES too.
        tasks: Brakings, all of one period.
        population: To begin with.
        draws: Seed of the search, and generations before this stage.
        threads: That evaluate candidates.
    """

    kind: Kind
    tasks: Sequence[Task]
    population: Array
    generations: int
    draws: tuple[int, int]
    threads: int


def tune(kind: Kind, tasks: Sequence[Task], search: Search, work: Work) -> tuple[Noise, float, list[float]]:
    """Return the noises that minimise an objective over brakings, its value, and the best after each generation.

    Raises:
        EstimationError: The brakings have different periods.
    """
    periods = {task.period for task in tasks}
    if len(periods) != 1:
        raise EstimationError(f"tuning wants brakings of one period, got {sorted(periods)} s; resample them.")
    population, history, lowest = _first(search), list[float](), np.inf
    while len(history) < search.generations:
        stage = Stage(
            kind=kind,
            tasks=tasks,
            population=population,
            generations=min(search.stage, search.generations - len(history)),
            draws=(search.seed, len(history)),
            threads=work.count,
        )
        ((population, lowest, best_of_each),) = work.map(evolved, [stage])
        history += best_of_each
        work.notify(f"generation {len(history)}, best {lowest:.6f} m/s")
        if not best_of_each:
            break
    return Noise.of(population[0]), lowest, history


def evolved(stage: Stage) -> tuple[Array, float, list[float]]:
    """Return the population after a stage, the best first, its value, and the best after each generation."""
    period, model, mine = stage.tasks[0].period, equations(), thread_local()
    history: list[float] = []

    def objective(logarithms: Array) -> float:
        # A filter's memory belongs to one thread; C runs outside Python's lock, so threads are enough.
        if not hasattr(mine, "filter"):
            mine.filter = filter_of(model, period)
        return evaluate(stage.kind, stage.tasks, mine.filter, Noise.of(logarithms))

    def note(intermediate_result: object) -> None:
        history.append(float(intermediate_result.fun))  # pyright: ignore[reportAttributeAccessIssue]

    filter_of(model, period)  # compiled once, before the threads would do it at the same time
    with ThreadPoolExecutor(stage.threads) as pool:
        optimum = differential_evolution(
            objective,
            _limits(),
            init=stage.population,  # pyright: ignore[reportArgumentType] - the stubs know names only
            maxiter=stage.generations,
            rng=np.random.default_rng(stage.draws),
            strategy="best1bin",
            mutation=(0.4, 0.9),
            recombination=0.8,
            updating="deferred",
            workers=pool.map,  # pyright: ignore[reportArgumentType] - wants no keyword of map's
            polish=False,
            # All generations are run: a population that has drawn together early says so in its history.
            tol=0.0,
            callback=note,
        )
    order = np.argsort(optimum.population_energies, kind="stable")
    return optimum.population[order], float(optimum.fun), history


def _limits() -> list[tuple[float, float]]:
    return [BOUNDS.get(name, BOUNDS[name.rstrip("1234")]) for name in NAMES]


def _first(search: Search) -> Array:
    """Return a first population: a Latin hypercube, and in it the noises of `PHYSICAL`, so that none worse is found."""
    limits = np.array(_limits()).T
    sample = qmc.LatinHypercube(len(NAMES), rng=np.random.default_rng(search.seed)).random(search.population)
    population = qmc.scale(sample, *limits)
    population[0] = np.clip(PHYSICAL.logarithms, *limits)
    return population
