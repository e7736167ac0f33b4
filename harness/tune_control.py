"""Searches the parameters of adhesion-based control, on rails that no result is reported of.

What the table of braking distances says of the controller is a prediction only if its parameters were not chosen by
that table. So they are chosen here, by differential evolution (Storn and Price, 1997) over the campaign `training`,
whose rails differ from those of every other campaign in shape, level, speed and draw.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from harness.scenario.campaign import PlannedStop, load_campaign
from harness.scenario.merge import merged
from harness.scenario.schema import Scenario
from harness.workers import workers

RAILS = Path(__file__).parent / "scenario" / "campaigns" / "training.toml"
EDGES = {"ideal": "ideal", "pneumatic": "service"}
"""Kind of actuation → variant of the axis `edge` whose stops it is tuned on."""

RANGES: Mapping[str, Mapping[str, tuple[float, float]]] = {
    "ideal": {
        "filter_time": (3e-3, 50e-3),
        "margin": (3e-3, 0.1),
        "rise": (0.03, 0.5),
        "fall": (0.03, 0.5),
        "slip_rate_max": (1.0, 20.0),
        "slip_rate_min": (0.02, 1.0),
        "dwell": (3e-3, 0.3),
    },
    "pneumatic": {
        "filter_time": (30e-3, 0.5),
        "margin": (3e-3, 0.1),
        "rise": (0.03, 0.5),
        "fall": (0.03, 0.5),
        "slip_rate_max": (0.3, 10.0),
        "slip_rate_min": (0.02, 1.0),
        "dwell": (0.03, 1.0),
        "slip_small": (1e-3, 3e-2),
    },
}
"""Where each parameter is searched, on a logarithmic scale: from quicker than the actuation to slower than the rail.
From what slip on there is a peak to seek depends on what sensors can tell from none; ideal ones tell any."""

_ENDLESS = 2000.0  # m, where the train does not stop
_SEED = 2021
POPULATION, GENERATIONS = 32, 5

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Objective:
    """Mean of ln(distance) over stops: every rail counts by the share of its own distance that a change saves."""

    names: tuple[str, ...]
    stops: tuple[Scenario, ...]

    def __call__(self, point: Vector) -> float:
        """Return it for the logarithms of the parameters."""
        values = values_of(self.names, point)
        return float(np.mean([math.log(_distance(_with(values, stop))) for stop in self.stops]))


def values_of(names: Sequence[str], point: Vector) -> dict[str, float]:
    """Return parameters for their logarithms, to two digits: finer ones move distances by less than chance does."""
    return {name: float(f"{math.exp(value):.2g}") for name, value in zip(names, point, strict=True)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """Parameters found for one kind of actuation.

    Attributes:
        values: By name.
        rails: Name of each rail.
        distances: With them [m].
        slip_based: Of two-level control [m].
    """

    values: Mapping[str, float]
    rails: tuple[str, ...]
    distances: tuple[float, ...]
    slip_based: tuple[float, ...]

    @property
    def reduction(self) -> float:
        """Geometric mean of distance over that of slip-based control, less 1."""
        ratios = np.array(self.distances) / np.array(self.slip_based)
        return float(np.exp(np.mean(np.log(ratios)))) - 1.0


def search(
    actuation: str,
    tell: Callable[[int, float], None],
    *,
    processes: int = 2,
    rails: Path = RAILS,
    population: int = POPULATION,
    generations: int = GENERATIONS,
) -> Found:
    """Search the parameters for one kind of actuation.

    Args:
        actuation: A key of `RANGES`.
        tell: Called after each generation with its number and the best reduction against slip-based control.
        processes: To run stops in.
        rails: Campaign with the axes rail, edge and controller.
        population: Sets of parameters in a generation, a power of two above the number of parameters.
        generations: After the first, which is drawn.
    """
    from scipy.optimize import Bounds, differential_evolution

    planned = load_campaign(rails).stops
    mine = [stop for stop in planned if stop.variants["edge"] == EDGES[actuation]]
    seeking, sliding = (_under(mine, kind) for kind in ("adhesion_based", "slip_two_state"))
    ranges = RANGES[actuation]
    objective = Objective(tuple(ranges), tuple(stop.scenario for stop in seeking))
    with workers(processes) as pool:
        slip_based = list(pool.map(_distance, [stop.scenario for stop in sliding]))
        reference = float(np.mean(np.log(slip_based)))
        generation = 0

        def mapped(function: Objective, points: Iterable[Vector]) -> list[float]:
            return list(pool.map(function, points))

        def note(intermediate_result: Any) -> None:
            nonlocal generation
            generation += 1
            tell(generation, math.expm1(intermediate_result.fun - reference))

        found = differential_evolution(
            objective,
            Bounds(*np.log(np.array(list(ranges.values())).T)),
            init="sobol",
            popsize=population // len(ranges),
            maxiter=generations,
            tol=0.0,
            polish=False,
            rng=_SEED,
            updating="deferred",
            workers=cast("Any", mapped),  # the stubs want a number, the function takes a map, too
            callback=note,
        )
        values = values_of(tuple(ranges), found.x)
        distances = list(pool.map(_distance, [_with(values, stop.scenario) for stop in seeking]))
    return Found(
        values=values,
        rails=tuple(stop.variants["rail"] for stop in seeking),
        distances=tuple(distances),
        slip_based=tuple(slip_based),
    )


def text_of(found: Mapping[str, Found]) -> str:
    """Return the file of parameters: what was found for each kind of actuation, and on what."""
    lines = ["# Adhesion-based control, one set for each kind of actuation: written by `make tune-control`."]
    for actuation, one in found.items():
        lines += ["", f"# {100 * one.reduction:+.1f} % against slip-based control, on:"]
        for rail, distance, other in zip(one.rails, one.distances, one.slip_based, strict=True):
            lines.append(f"#   {rail}: {distance:.1f} m ({other:.1f} m)")
        lines += [f"[{actuation}]", *(f"{name} = {value!r}" for name, value in one.values.items())]
    return "\n".join(lines) + "\n"


def _under(stops: Sequence[PlannedStop], controller: str) -> list[PlannedStop]:
    return [stop for stop in stops if stop.variants["controller"] == controller]


def _with(values: Mapping[str, float], scenario: Scenario) -> Scenario:
    """Return a scenario whose controller has other parameters."""
    return Scenario.model_validate(merged(scenario.resolved(), {"controller": {"parameters": dict(values)}}))


def _distance(scenario: Scenario) -> float:
    from harness.assemble import braking_distance

    distance = braking_distance(scenario)
    return _ENDLESS if distance is None else distance
