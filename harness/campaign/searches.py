"""Search numbers: levels of the low-adhesion scenarios, and parameters of brake control on rails of their own.

*Levels.* Schwarz, Posielek and Goetjes (2021) give the friction of their scenarios only as a figure without numbers,
and do not state their Polach parameters. One factor on the friction of each scenario is fitted, for each shape of the
creep curve, so that slip-based two-level control with ideal actuation and sensors stops in the distance of their Table
1. All other entries of the table, above all those of adhesion-based control, are then predictions.

*Parameters.* The table of braking distances predicts the performance of a controller only if its parameters were not
chosen by that table, and compares controllers fairly only if all were tuned with the same effort. So the parameters of
all of them, adhesion-based control and the slip-based control that it is compared with, are searched here, by
differential evolution (Storn and Price, 1997) over the campaign `training`, whose rails differ from those of every
other campaign in shape, level, speed and draw; or, for the type test, over a separate set of cases.
"""

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np
from scipy.optimize import Bounds, differential_evolution
from scipy.stats.qmc import Sobol

from railgrip.base import registry
from railgrip.base.arrays import Vector
from railgrip.base.files import write_text
from railgrip.campaign.workers import workers
from railgrip.controllers.law import GroupLaw
from railgrip.controllers.law import Ranges as LawRanges
from railgrip.controllers.parameters import SEARCHED, TYPE_TEST, SlipSource, file_of, tuned_values
from railgrip.scenario.campaign import PlannedStop, load_campaign
from railgrip.scenario.load import load
from railgrip.scenario.schema import Scenario
from railgrip.simulate.run import braking_distance

TARGETS = {"trapezoid": 382.9, "sine_sweep": 316.2, "random": 339.6}
"""Braking distance of slip-based control [m]: Schwarz, Posielek and Goetjes (2021), Table 1."""

SHAPES = ("dry", "wet", "low_steep", "poor_wheelset_study")
"""Published shapes of the creep curve for which levels are fitted."""

LIBRARY = Path(__file__).parents[1] / "scenario" / "library"

_CLOSE = 0.05  # m: the table has tenths of a metre; the required bound is 1 %, some 3 m
_ROUNDS = 25


class FittedLevel(NamedTuple):
    """Scenario of the library, named Polach set, factor on the friction, and the resulting distance [m] of SBC."""

    scenario: str
    shape: str
    level: float
    distance: float


def calibrate(scenarios: Sequence[str], folder: Path, notify: Callable[[FittedLevel], None]) -> list[FittedLevel]:
    """Fit the levels of scenarios of the library for every shape of the creep curve; write their files to a folder.

    Raises:
        ArithmeticError: The distance is not reached with a level from 0.3 to 3.
    """
    fits: list[FittedLevel] = []
    with workers(2) as pool:
        futures = [pool.submit(fit, scenario, shape) for scenario in scenarios for shape in SHAPES]
        for answer in futures:
            fits.append(answer.result())
            notify(fits[-1])
    for scenario in scenarios:
        text = (LIBRARY / f"{scenario}.toml").read_text(encoding="utf-8")
        levels = {fit.shape: fit.level for fit in fits if fit.scenario == scenario}
        write_text(folder / f"{scenario}.toml", with_levels(text, levels))
    return fits


def fit(scenario: str, shape: str, library: Path = LIBRARY) -> FittedLevel:
    """Find the level at which slip-based control stops in the published distance, by regula falsi (Illinois).

    Raises:
        ArithmeticError: The distance is not reached with a level from 0.3 to 3.
    """
    target = TARGETS[scenario]

    def excess(level: float) -> float:
        overrides = [
            "controller.kind=slip_two_state",
            "estimator.kind=none",
            f"adhesion.polach={shape}",
            f"adhesion.calibrated.{shape}={level!r}",
        ]
        distance = braking_distance(load(library / f"{scenario}.toml", overrides))
        # A train that slides until the horizon is on a rail that is far too slippery.
        return 1e3 if distance is None else distance - target

    low, high = 0.6, 1.6
    over, under = excess(low), excess(high)
    while over < 0.0 and low > 0.3:
        low *= 0.8
        over = excess(low)
    while under > 0.0 and high < 3.0:
        high *= 1.2
        under = excess(high)
    if over < 0.0 or under > 0.0:
        raise ArithmeticError(f"{scenario}, {shape}: no level between 0.3 and 3 stops in {target} m.")
    level, residual = low, over
    for _ in range(_ROUNDS):
        # The file has five digits; finer steps would change the distance by less than the tolerance.
        level = round(low + (high - low) * over / (over - under), 5)
        residual = excess(level)
        if abs(residual) < _CLOSE or high - low < 2e-5:
            break
        if residual > 0.0:
            low, over, under = level, residual, 0.5 * under
        else:
            high, under, over = level, residual, 0.5 * over
    return FittedLevel(scenario, shape, level, target + residual)


def with_levels(text: str, levels: dict[str, float]) -> str:
    """Return the text of a scenario file with other calibrated levels; all other lines are unchanged."""
    line = "calibrated = { " + ", ".join(f"{shape} = {level:.5f}" for shape, level in levels.items()) + " }"
    result, count = re.subn(r"(?m)^calibrated = .*$", line, text)
    if count != 1:
        raise ValueError("a scenario of the library has exactly one line 'calibrated = …' in [adhesion]")
    return result


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


Mapped = Callable[[Callable[[Vector], float], Iterable[Vector]], list[float]]
"""Returns the values of a function at points."""


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
        objective, ranges, start, effort, lambda function, points: list(pool.map(function, points)),
        lambda n, mean: notify(n, math.expm1(mean - reference_mean)),
        evenly=budget is not None,
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
    objective: Callable[[Vector], float],
    ranges: Ranges,
    start: Mapping[str, float],
    effort: tuple[int, int],
    mapped: Mapped,
    notify: Callable[[int, float], None],
    *,
    evenly: bool,
) -> Vector:
    """Return the point with the minimum objective that differential evolution finds.

    Args:
        start: Parameters of one point of the first population.
        effort: Size of the population, and number of generations after the first.
        mapped: Returns the objective at each of several points.
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
        objective,
        Bounds(*bounds),
        x0=point_of(ranges, start),
        init=bounds[0] + unit_points * (bounds[1] - bounds[0]) if evenly else "sobol",
        popsize=population // len(ranges),
        maxiter=generations,
        tol=0.0,
        polish=False,
        rng=_SEED,
        updating="deferred",
        workers=cast("Any", mapped),  # the stubs expect a number, the function also accepts a map
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
    change: dict[str, Any] = {"controller": {"kind": law}} | ({"estimator": {"kind": "none"}} if slip == "read" else {})
    return scenario.revised(change)


def _with(values: Mapping[str, float], scenario: Scenario) -> Scenario:
    return scenario.revised({"controller": {"parameters": dict(values)}})


def _distance(scenario: Scenario) -> float:
    distance = braking_distance(scenario)
    return _ENDLESS if distance is None else distance
