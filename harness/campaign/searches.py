"""Search the parameters of brake control on rails of their own.

The table of braking distances predicts the performance of a controller only if its parameters were not chosen by that
table, and compares controllers fairly only if all were tuned with the same effort. So the parameters of all of them,
adhesion-based control and the slip-based control that it is compared with, are searched here, by differential evolution
(Storn and Price, 1997) over the campaign `training`, whose rails differ from those of every other campaign in shape,
level, speed and draw; or, for the type test, over a separate set of cases.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, cast

import numpy as np
from scipy.optimize import Bounds, differential_evolution
from scipy.stats.qmc import Sobol

from railgrip.base import registry
from railgrip.base.arrays import Vector
from railgrip.base.tables import TomlTable
from railgrip.controllers.law import GroupLaw
from railgrip.controllers.law import Ranges as LawRanges
from railgrip.controllers.parameters import SEARCHED, TYPE_TEST, SlipSource, file_of, tuned_values
from railgrip.scenario.campaign import PlannedStop, load_campaign
from railgrip.scenario.schema import Scenario
from railgrip.simulate.run import braking_distance

RAILS = Path(__file__).parents[1] / "scenario" / "campaigns" / "training.toml"
EQUIPMENT = {"ideal": "ideal", "pneumatic": "service"}
"""Kind of actuation → variant of the axis `equipment` for its training stops."""

Ranges = Mapping[str, tuple[float, float]]

_HIGHEST = 0.9
"""Maximum of the searched upper slip level: a wheel that is nearly locked."""

RANGES: Mapping[str, LawRanges] = {
    kind: law.ranges
    for kind in registry.modules(registry.LAWS)
    if (law := registry.part(registry.LAWS, kind, GroupLaw)).ranges
}
"""Searched parameters of each law that has any."""

REFERENCE = "slip_two_state"
"""The law that results are compared with, with the paper's levels and the slip as read."""

_ENDLESS = 2000.0  # m, for a train that does not stop
_SEED = 2021
_SETS = 24
"""Sets of parameters that are tried per searched parameter: the same effort for every law."""


def mean_logarithm(names: tuple[str, ...], stops: tuple[Scenario, ...], point: Vector) -> float:
    """Return the mean of ln(distance) over stops: every rail is weighted by its relative saving."""
    values = parameters_of(names, point)
    return float(np.mean([math.log(_distance(_with(values, stop))) for stop in stops]))


def parameters_of(names: Sequence[str], point: Vector) -> dict[str, float]:
    """Return the law's parameters for the logarithms of the searched quantities.

    They are rounded to two digits: finer differences have less effect than chance. The upper slip level is searched as
    a ratio to the lower one, so that every point is a valid pair.
    """
    values = {name: math.exp(value) for name, value in zip(names, point, strict=True)}
    if "high_over_low" in values:
        values["high"] = min(_HIGHEST, values["low"] * values.pop("high_over_low"))
    return {name: float(f"{value:.2g}") for name, value in values.items()}


def point_of(ranges: Ranges, values: Mapping[str, float]) -> Vector:
    """Return the logarithms of the searched quantities for parameters of a law, clipped to their ranges."""
    start = dict(values)  # a parameter that is missing in the file starts in the middle
    if "high_over_low" in ranges:
        start["high_over_low"] = start["high"] / start["low"]
    point = [math.log(start.get(name, math.sqrt(low * high))) for name, (low, high) in ranges.items()]
    return np.clip(point, *np.log(np.array(list(ranges.values())).T))


@dataclass(frozen=True, slots=True, kw_only=True)
class Optimum:
    """Parameters found for a law with one kind of actuation and one source of the slip.

    Attributes:
        values: Values by name.
        sets: Number of sets of parameters tried.
        rails: Name of each rail.
        distances: Distance on each rail with them [m].
        reference: Distance of two-state slip-based control with the paper's levels [m].
    """

    values: Mapping[str, float]
    sets: int
    rails: tuple[str, ...]
    distances: tuple[float, ...]
    reference: tuple[float, ...]

    @property
    def reduction(self) -> float:
        """Geometric mean of the distance over that of the reference, minus 1."""
        ratios = np.array(self.distances) / np.array(self.reference)
        return float(np.exp(np.mean(np.log(ratios)))) - 1.0


def search(
    law: str,
    actuation: str,
    slip: SlipSource,
    notify: Callable[[int, float], None],
    pool: Executor,
    *,
    rails: Path = RAILS,
    rail_stops: Sequence[PlannedStop] | None = None,
    version: int | None = None,
    sets: int = _SETS,
    budget: int | None = None,
) -> Optimum:
    """Search the parameters of one law for one kind of actuation and one source of the slip.

    The first population includes the set in the law's file, so that a search continues the previous one.

    Args:
        law: A key of `RANGES`.
        actuation: First element of the key of its ranges.
        slip: Second element.
        notify: Called after each generation with its number and the best reduction against the reference.
        rails: Campaign with the axes rail and equipment.
        rail_stops: Training cases of the type test in place of rails, each with the variant rail.
        version: Version of the type test that they are of; None for rails.
        sets: Sets of parameters to try per searched parameter; rounded up to whole generations.
        budget: Total number of sets to try; None for `sets`.
    """
    name = set_of(law, version)
    file = registry.files(registry.LAWS)[file_of(law, name).removesuffix(".toml")]
    start = tuned_values(file, name, actuation, slip)
    if rail_stops is None:
        rail_stops = [stop for stop in load_campaign(rails).stops if stop.variants["equipment"] == EQUIPMENT[actuation]]
    scenarios = [stop.scenario for stop in rail_stops]
    ranges = RANGES[law][actuation, slip]
    stops = tuple(_under(law, slip, scenario) for scenario in scenarios)
    objective = partial(mean_logarithm, tuple(ranges), stops)
    reference = list(pool.map(_distance, [_under(REFERENCE, "read", scenario) for scenario in scenarios]))
    reference_mean = float(np.mean(np.log(reference)))
    effort = _effort(len(ranges), sets, budget)
    best = evolve(
        lambda points: list(pool.map(objective, points)), ranges, effort, start,
        lambda n, mean: notify(n, math.expm1(mean - reference_mean)), evenly=budget is not None,
    )  # fmt: skip
    values = parameters_of(tuple(ranges), best)
    distances = list(pool.map(_distance, [_with(values, stop) for stop in stops]))
    return Optimum(
        values=values,
        sets=effort[0] * (effort[1] + 1),
        rails=tuple(stop.variants["rail"] for stop in rail_stops),
        distances=tuple(distances),
        reference=tuple(reference),
    )


def evolve(
    objectives: Callable[[Iterable[Vector]], list[float]],
    ranges: Ranges,
    effort: tuple[int, int],
    start: Mapping[str, float] = MappingProxyType({}),
    notify: Callable[[int, float], None] = lambda number, best: None,
    *,
    evenly: bool = True,
) -> Vector:
    """Return the point with the minimum objective that differential evolution finds.

    Args:
        objectives: Returns the objective at each of several points.
        ranges: Ranges of the parameters.
        effort: Size of the population, and number of generations after the first.
        start: Parameters of one point of the first population; the middles of the ranges unless given.
        notify: Called after each generation with its number and the minimum objective.
        evenly: Whether the rest of the first population are Sobol points, whatever their number; else SciPy chooses.
    """
    population, generations = effort
    bounds = np.log(np.array(list(ranges.values())).T)
    unit_points = Sobol(len(ranges), rng=_SEED).random_base2(math.ceil(math.log2(population)))[:population]
    generation = 0

    def note(intermediate_result: Any) -> None:
        nonlocal generation
        generation += 1
        notify(generation, intermediate_result.fun)

    optimum = differential_evolution(
        lambda point: objectives([point])[0],
        Bounds(*bounds),
        x0=point_of(ranges, start),
        init=bounds[0] + unit_points * (bounds[1] - bounds[0]) if evenly else "sobol",
        popsize=population // len(ranges),
        maxiter=generations,
        tol=0.0,
        polish=False,
        rng=_SEED,
        updating="deferred",
        # The stubs expect a number, the function also accepts a map.
        workers=cast("Any", lambda _, points: objectives(points)),
        callback=note,
    )
    return optimum.x


def _effort(parameters: int, sets: int, budget: int | None) -> tuple[int, int]:
    # Sobol points come in powers of two; a population of twice the number of parameters is small, but sufficient.
    population = 1 << max(3, math.ceil(math.log2(2 * parameters)))
    if budget is not None and budget < 2 * population:
        population = budget  # too few to evolve: the best of points spaced evenly over the ranges
    return population, max(0, math.ceil((sets * parameters if budget is None else budget) / population) - 1)


def set_of(law: str, version: int | None) -> str:
    """Return the name of the set that a search finds.

    Args:
        law: A key of `RANGES`.
        version: Version of the type test whose training cases are searched; None for the training rails.

    Returns:
        The set of that version, if the law has one, or the only one.
    """
    name = TYPE_TEST.get(version or 0, SEARCHED)
    return name if f"{law}.{name}" in registry.files(registry.LAWS) else SEARCHED


def text_of(law: str, results: Mapping[tuple[str, SlipSource], Optimum], command: str = "make tune-control") -> str:
    """Return the file of a law's parameters: the results for each kind of actuation, their rails, and the command."""
    lines = [f"# Parameters of {law}, written by `{command}`; in brackets two-state control at 10 and 15 %."]
    for (actuation, slip), result in results.items():
        lines += [
            "",
            f"# The best of {result.sets} sets: {100 * result.reduction:+.1f} % against slip-based control, on:",
        ]
        for rail, distance, other in zip(result.rails, result.distances, result.reference, strict=True):
            lines.append(f"#   {rail}: {distance:.1f} m ({other:.1f} m)")
        lines += [f"[{actuation}.{slip}]", *(f"{name} = {value!r}" for name, value in result.values.items())]
    return "\n".join(lines) + "\n"


def _under(law: str, slip: str, scenario: Scenario) -> Scenario:
    change: TomlTable = {"controller": {"kind": law}} | ({"estimator": {"kind": "none"}} if slip == "read" else {})
    return scenario.revised(change)


def _with(values: Mapping[str, float], scenario: Scenario) -> Scenario:
    return scenario.revised({"controller": {"parameters": dict(values)}})


def _distance(scenario: Scenario) -> float:
    distance = braking_distance(scenario)
    return _ENDLESS if distance is None else distance
