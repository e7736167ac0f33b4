"""Table 1 of Schwarz, Posielek and Goetjes (2021) from all six of its distances: which creep curve and law give them.

The paper publishes neither its creep curve nor filter and threshold of its law, and friction only as a figure. Nine
numbers are free here, six distances are known. For each creep curve and law three levels of friction, one a scenario,
are solved for, so that slip-based control stops in the published distances; the three distances of adhesion-based
control, the law as printed, are what is fitted. It chatters, so that each is the median of repeats whose plant
parameters are perturbed by 1e-7.
"""

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq
from scipy.stats import qmc

from railgrip.api import Scenario
from railgrip.base.files import replacing
from railgrip.campaign.calibrate import TARGETS
from railgrip.campaign.work import Work, call
from railgrip.simulate.run import braking_distance

SCENARIOS: tuple[str, ...] = ("trapezoid", "sine_sweep", "random")
SBC = TARGETS
"""Table 1, braking distances of slip-based control [m]."""
ABC = {"trapezoid": 333.4, "sine_sweep": 286.6, "random": 309.6}
"""Table 1, braking distances of adhesion-based control [m]."""

PERTURBATION = 1e-7
SEARCHED: Mapping[str, int] = {"sbc": 1, "abc": 3}
"""Repeats of a stop in the search: rounding moves slip-based control by 0.1 %, the law as printed by up to 2 %."""
FINAL: Mapping[str, int] = {"sbc": 20, "abc": 20}
"""Repeats of a stop of the result."""

LEVELS = (0.5, 2.5)
"""Where a level is looked for, a factor on the friction of the scenario file."""
_LEVEL_STEP = 5e-4  # moves a distance by 0.05 %, below what rounding moves it by

EQUAL = 0.02
"""Largest error of six distances, as a share, up to which fits count as equal: single repeats differ by up to 1.8 %."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """The six numbers that levels are solved for: creep curve, filter time [s] and threshold of the law."""

    k_A: float  # noqa: N815 (the name in the literature)
    k_S: float  # noqa: N815 (the name in the literature)
    A: float
    B: float
    filter_time: float
    slip_small: float

    @property
    def polach(self) -> dict[str, float]:
        """The creep curve as scenario files have it."""
        return {"k_A": self.k_A, "k_S": self.k_S, "A": self.A, "B": self.B}


@dataclass(frozen=True, slots=True, kw_only=True)
class Fitted:
    """A candidate with its levels, and the medians of both controllers' distances [m], by scenario.

    A scenario without a level has no distances: NaN.
    """

    candidate: Candidate
    levels: Mapping[str, float]
    sbc: Mapping[str, float]
    abc: Mapping[str, float]

    @property
    def errors(self) -> list[float]:
        """Relative errors of the six distances, slip-based control first."""
        return [
            ours[name] / paper[name] - 1 for ours, paper in ((self.sbc, SBC), (self.abc, ABC)) for name in SCENARIOS
        ]

    @property
    def largest(self) -> float:
        """The largest of them; infinite where a level was not found."""
        worst = float(np.max(np.abs(self.errors)))
        return worst if math.isfinite(worst) else math.inf


DEFAULT = Candidate(k_A=1.0, k_S=0.4, A=0.4, B=0.6, filter_time=0.0042, slip_small=0.003)
"""The published shape that the scenarios have, Polach's dry one, and the filter of our own law."""

# Bounds: Polach (2005) has k_S ≤ k_A ≤ 1; published A are 0.1 to 0.5, B 0.1 to 0.6 s/m, given room on either side. The
# filter is between one sample of the controller and the time in which the rail changes; the threshold below all peaks.
BOUNDS: Mapping[str, tuple[float, float]] = {
    "k_A": (0.03, 1.0),
    "k_S/k_A": (0.1, 1.0),
    "A": (0.05, 0.8),
    "B": (0.05, 1.5),
    "filter_time": (1e-3, 0.1),
    "slip_small": (3e-4, 0.02),
}
_LOGARITHMIC = ("k_A", "k_S/k_A", "B", "filter_time", "slip_small")


def candidate_at(point: Sequence[float]) -> Candidate:
    """Return the candidate at a point of the unit cube, axes in the order of `BOUNDS`."""
    values: dict[str, float] = {}
    for (name, (low, high)), share in zip(BOUNDS.items(), point, strict=True):
        values[name] = low * (high / low) ** share if name in _LOGARITHMIC else low + (high - low) * share
    ratio = values.pop("k_S/k_A")
    # Four digits are what is written: the file holds all that a distance needs to be found again.
    return Candidate(k_S=_rounded(ratio * values["k_A"]), **{name: _rounded(value) for name, value in values.items()})


def _rounded(value: float) -> float:
    return float(f"{value:.4g}")


def stop_of(name: str, candidate: Candidate, level: float, controller: str, seed: int | None = None) -> Scenario:
    """Return a scenario with a candidate's creep curve and one of the two controllers; perturbed by a seed."""
    changes: dict[str, Any] = {"adhesion.polach": candidate.polach, "adhesion.level": level}
    if controller == "sbc":
        changes |= {"controller.kind": "slip_two_state", "estimator.kind": "none"}
    else:
        parameters = {"filter_time": candidate.filter_time, "slip_small": candidate.slip_small}
        changes |= {"controller.kind": "adhesion_literal", "controller.parameters": parameters}
    if seed is not None:
        changes["vehicle.nudge"] = {"relative": PERTURBATION, "seed": seed}
    return Scenario.load(name, changes)


def median_distance(name: str, candidate: Candidate, level: float, controller: str, repeats: int) -> float:
    """Return the median of perturbed stops [m]; one without standstill counts as endless."""
    distances = [braking_distance(stop_of(name, candidate, level, controller, seed)) for seed in range(1, repeats + 1)]
    return float(np.median([math.inf if distance is None else distance for distance in distances]))


def fit(candidate: Candidate) -> Fitted:
    """Solve for the levels, and return both controllers' distances at them."""
    levels: dict[str, float] = {}
    for name in SCENARIOS:
        levels[name] = level = _level(name, candidate)
        if math.isnan(level):
            none = dict.fromkeys(SCENARIOS, math.nan)
            return Fitted(candidate=candidate, levels=none, sbc=none, abc=none)
    return at_levels(candidate, levels, SEARCHED)


def at_levels(candidate: Candidate, levels: Mapping[str, float], repeats: Mapping[str, int]) -> Fitted:
    """Return both controllers' distances at given levels, medians of so many repeats of each controller."""
    sbc, abc = (
        {name: median_distance(name, candidate, levels[name], controller, count) for name in SCENARIOS}
        for controller, count in repeats.items()
    )
    return Fitted(candidate=candidate, levels=levels, sbc=sbc, abc=abc)


def _level(name: str, candidate: Candidate) -> float:
    """Return the level at which slip-based control stops in the published distance; NaN if none within `LEVELS`."""

    @cache
    def excess(level: float) -> float:
        distance = braking_distance(stop_of(name, candidate, level, "sbc"))
        # Where it slides on until the horizon, the rail is far too slippery.
        return math.log((4 * SBC[name] if distance is None else distance) / SBC[name])

    if excess(LEVELS[0]) < 0 or excess(LEVELS[1]) > 0:
        return math.nan
    solution: Any = brentq(excess, *LEVELS, xtol=_LEVEL_STEP)
    return round(float(solution), 5)


STAGES = (64, 16, 16, 16, 16)
"""Candidates of a Sobol sequence over all bounds, then around the best so far, ever closer."""
PARENTS = 6
FIRST_WIDTH = 0.12
"""1σ of the first stage around the best, as a share of the bounds; each next one has two thirds of it."""


def search(work: Work, stages: Sequence[int] = STAGES, seed: int = 1) -> list[Fitted]:
    """Return all fits of a deterministic global search, the best first: Sobol points, then an evolution strategy."""
    points = [list(point) for point in qmc.Sobol(len(BOUNDS), rng=seed).random(stages[0])]
    fits = dict(zip(map(tuple, points), work.map(fit, [candidate_at(point) for point in points]), strict=True))
    generator, width = np.random.default_rng(seed), FIRST_WIDTH
    for count in stages[1:]:
        parents = sorted(fits, key=lambda point: fits[point].largest)[:PARENTS]
        moved = [
            np.clip(np.array(parents[number % len(parents)]) + width * generator.standard_normal(len(BOUNDS)), 0, 1)
            for number in range(count)
        ]
        children = [tuple(float(share) for share in point) for point in moved]
        fits |= dict(zip(children, work.map(fit, [candidate_at(point) for point in children]), strict=True))
        width *= 2 / 3
    return sorted(fits.values(), key=lambda fit: fit.largest)


def refined(work: Work, fits: Sequence[Fitted], count: int = 6) -> Fitted:
    """Return the best of the first few fits by the medians of `FINAL` repeats."""
    again = work.map(call, [partial(at_levels, fit.candidate, fit.levels, FINAL) for fit in fits[:count]])
    return min(again, key=lambda fit: fit.largest)


def write_fits(path: Path, fits: Sequence[Fitted]) -> None:
    """Write fits as CSV, a line each."""
    with replacing(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*_NUMBERS, *(f"{kind}_{name}" for kind in ("level", "sbc", "abc") for name in SCENARIOS)])
        for fit in fits:
            numbers = [getattr(fit.candidate, name) for name in _NUMBERS]
            distances = [round(values[name], 2) for values in (fit.sbc, fit.abc) for name in SCENARIOS]
            writer.writerow([*numbers, *(fit.levels[name] for name in SCENARIOS), *distances])


def read_fits(path: Path) -> list[Fitted]:
    """Return the fits in a file that `write_fits` wrote."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    return [
        Fitted(
            candidate=Candidate(**{name: row[name] for name in _NUMBERS}),
            levels={name: row[f"level_{name}"] for name in SCENARIOS},
            sbc={name: row[f"sbc_{name}"] for name in SCENARIOS},
            abc={name: row[f"abc_{name}"] for name in SCENARIOS},
        )
        for row in rows
    ]


_NUMBERS = ("k_A", "k_S", "A", "B", "filter_time", "slip_small")
