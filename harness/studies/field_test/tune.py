"""Finding the twelve noises of equation (13): differential evolution, in stages that can be taken up again.

A stage is a few generations from the population that the last one left, with random numbers of its own: a run that was
interrupted goes on from the last whole stage and ends with the same bytes as one that was not.
"""

import hashlib
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from threading import local as thread_local

import numpy as np
from scipy.optimize import differential_evolution
from scipy.stats import qmc

from railgrip.errors import EstimationError
from railgrip.estimators.belief import Array
from railgrip.estimators.prediction import CasadiPrediction
from railgrip.files import replacing
from railgrip.studies.field_test.filtering import Task, filter_of
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
        stage: Generations between two checkpoints.
    """

    population: int
    generations: int
    stage: int
    seed: int
    workers: int


def tune(
    kind: Kind,
    tasks: Sequence[Task],
    model: CasadiPrediction,
    search: Search,
    checkpoint: Path,
    tell: Callable[[int, float], None] = lambda generation, best: None,
) -> tuple[Noise, float, list[float]]:
    """Return the noises that minimise an objective over brakings, its value, and the best after each generation.

    Args:
        kind: `paper` for equation (14), `consistent` to weigh NIS and NEES too.
        tasks: Brakings, all of one period.
        model: Of `filtering.equations`, which the threads of the search share.
        checkpoint: File (`.npz`) where the search is kept after every stage, and found again.

    Raises:
        EstimationError: The checkpoint belongs to another search, or the brakings have different periods.
    """
    periods = {task.period for task in tasks}
    if len(periods) != 1:
        raise EstimationError(f"tuning wants brakings of one period, got {sorted(periods)} s; resample them.")
    period = periods.pop()
    mine = thread_local()

    def objective(logarithms: Array) -> float:
        # A filter's memory belongs to one thread; C runs outside Python's lock, so threads are enough.
        if not hasattr(mine, "filter"):
            mine.filter = filter_of(model, period)
        return evaluate(kind, tasks, mine.filter, Noise.of(logarithms))

    limits = [BOUNDS.get(name, BOUNDS[name.rstrip("1234")]) for name in NAMES]
    identity = _identity(kind, tasks, search)
    population, history = _from_checkpoint(checkpoint, identity) or (_first(search, limits), [])
    filter_of(model, period)  # compiled once, before the threads would do it at the same time
    best, lowest = Noise.of(population[0]), history[-1] if history else np.inf
    with ThreadPoolExecutor(search.workers) as pool:
        while len(history) < search.generations:
            before = len(history)

            def note(intermediate_result: object) -> None:
                history.append(float(intermediate_result.fun))  # pyright: ignore[reportAttributeAccessIssue]
                tell(len(history), history[-1])

            optimum = differential_evolution(
                objective,
                limits,
                init=population,  # pyright: ignore[reportArgumentType] - the stubs know names only
                maxiter=min(search.stage, search.generations - before),
                rng=np.random.default_rng([search.seed, before]),
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
            population = optimum.population
            order = np.argsort(optimum.population_energies, kind="stable")
            population = population[order]
            best, lowest = Noise.of(population[0]), float(optimum.fun)
            with replacing(checkpoint) as partial, partial.open("wb") as file:
                np.savez(file, population=population, history=np.array(history), identity=np.array(identity))
            if len(history) == before:
                break
    return best, lowest, history


def _first(search: Search, limits: Sequence[tuple[float, float]]) -> Array:
    """Return a first population: a Latin hypercube, and in it the noises of `PHYSICAL`, so that none worse is found."""
    sample = qmc.LatinHypercube(len(limits), rng=np.random.default_rng(search.seed)).random(search.population)
    population = qmc.scale(sample, *np.array(limits).T)
    population[0] = np.clip(PHYSICAL.logarithms, *np.array(limits).T)
    return population


def _identity(kind: Kind, tasks: Sequence[Task], search: Search) -> str:
    """Return what tells searches apart: what is minimised, over which readings, from which random numbers."""
    digest = hashlib.sha256(f"{kind} {search.population} {search.stage} {search.seed}".encode())
    for task in tasks:
        digest.update(task.inputs.tobytes())
        digest.update(task.readings.tobytes())
    return digest.hexdigest()


def _from_checkpoint(checkpoint: Path, identity: str) -> tuple[Array, list[float]] | None:
    """Return population and history of a search that was begun, or None."""
    if not checkpoint.exists():
        return None
    with np.load(checkpoint) as arrays:
        if str(arrays["identity"]) != identity:
            raise EstimationError(
                f"{checkpoint}: belongs to another search (other recordings, objective, population, stage or seed); "
                "move it away to begin anew."
            )
        return arrays["population"], [float(v) for v in arrays["history"]]
