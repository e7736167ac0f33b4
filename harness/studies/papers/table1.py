"""Identification of creep curve and law from all six distances of Table 1 of Schwarz, Posielek and Goetjes (2021).

The paper publishes neither its creep curve nor filter and threshold of its law, and friction only as a figure. Nine
numbers are free here, six distances are known. For each creep curve and law three levels of friction, one for each
scenario, are solved for, so that slip-based control stops in the published distances. The three distances of the law
as printed are fitted, under constraints: the creep curve is like published ones, no wheelset locks, and the sentences
of the paper about its results hold. The law chatters, so that each distance is the median of repeats whose plant
parameters are perturbed by 1e-7; the sentences are judged in the same repeats.
"""

import csv
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from railgrip.api import Scenario
from railgrip.base.files import replacing
from railgrip.campaign.calibrate import TARGETS
from railgrip.campaign.work import Work, call
from railgrip.report.stop import Stop
from railgrip.simulate.run import braking_distance, run_stop
from railgrip.simulate.vehicle import VehicleData
from railgrip.studies.papers.figure_4 import course_of_adhesion

SCENARIOS: tuple[str, ...] = ("trapezoid", "sine_sweep", "random")
SBC = TARGETS
"""Table 1, braking distances of slip-based control [m]."""
ABC = {"trapezoid": 333.4, "sine_sweep": 286.6, "random": 309.6}
"""Table 1, braking distances of adhesion-based control [m]."""

PERTURBATION = 1e-7
SEARCHED: Mapping[str, int] = {"sbc": 1, "abc": 7}
"""Repeats of a stop in the search: rounding moves slip-based control by 0.1 %, the law as printed by up to 2 %."""
FINAL: Mapping[str, int] = {"sbc": 5, "abc": 21}
"""Repeats of a stop of the result; an odd number, so that the median is a stop."""

LEVELS = (0.5, 2.5)
"""Range in which a level is searched, a factor on the friction of the scenario file."""
_CLOSE, _NEAR = 5e-4, 3e-3  # relative tolerances of a distance: below the effect of rounding; and at a jump
_GUESSES = {"trapezoid": 1.05, "sine_sweep": 1.18, "random": 1.19}
"""Start of the search for a level: of the trapezoid, and of the others relative to that of the trapezoid."""

EQUAL = 0.02
"""Relative error of the six distances up to which fits count as equal: single repeats differ by up to 1.8 %."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """Six free numbers, for which levels are solved: creep curve, filter time [s] and threshold of the law."""

    k_A: float  # noqa: N815 (the name in the literature)
    k_S: float  # noqa: N815 (the name in the literature)
    A: float
    B: float
    filter_time: float
    slip_small: float

    @property
    def polach(self) -> dict[str, float]:
        """The creep curve in the form of scenario files."""
        return {"k_A": self.k_A, "k_S": self.k_S, "A": self.A, "B": self.B}


@dataclass(frozen=True, slots=True, kw_only=True)
class CandidateFit:
    """A candidate with its levels, and the medians of both controllers' distances [m], by scenario.

    A scenario without a level has no distances: NaN.

    Attributes:
        share: Adhesion at 15 % slip over the maximum, see `creep_curve`; NaN without levels.
        holds: Share of the repeats on the trapezoid with the law as printed in which a sentence of `REQUIRED` holds;
            NaN if the error of the distances exceeds `PROMISING`.
    """

    candidate: Candidate
    levels: Mapping[str, float]
    sbc: Mapping[str, float]
    abc: Mapping[str, float]
    share: float
    holds: Mapping[str, float]

    @property
    def errors(self) -> list[float]:
        """Relative errors of the six distances, slip-based control first."""
        return [
            ours[name] / paper[name] - 1 for ours, paper in ((self.sbc, SBC), (self.abc, ABC)) for name in SCENARIOS
        ]

    @property
    def largest(self) -> float:
        """Largest relative error; infinite if a level was not found."""
        worst = float(np.max(np.abs(self.errors)))
        return worst if math.isfinite(worst) else math.inf

    @property
    def savings(self) -> list[float]:
        """Relative reduction of the distance by the law in comparison with slip-based control, by scenario."""
        return [1 - self.abc[name] / self.sbc[name] for name in SCENARIOS]

    @property
    def shortfalls(self) -> dict[str, float]:
        """Violation of each constraint by its name: 0 if it is met, infinite if it is unknown."""
        curve = {
            f"adhesion at 15 % slip ≥ {100 * SHARE:.0f} % of the greatest": SHARE - self.share,
        }
        sentences = {name: HOLDS - self.holds[name] for name in REQUIRED}
        return {name: math.inf if math.isnan(value) else max(0.0, value) for name, value in (curve | sentences).items()}

    @property
    def is_admissible(self) -> bool:
        """Whether all constraints are met."""
        return not any(self.shortfalls.values())

    @property
    def cost(self) -> float:
        """Objective of the search: the largest error, and the violations if the distances are promising."""
        known = [value for value in self.shortfalls.values() if math.isfinite(value)]
        return self.largest + sum(known) + (PROMISING if len(known) < len(self.shortfalls) else 0.0)


SHARE = 0.55
"""Minimum adhesion at 15 % slip over the maximum, at 80 km/h and the mean friction of the trapezoid, of a plausible
curve; Polach's dry one has 0.56."""
SAVING = 0.0875
"""The paper's "at least 8.8 %" before it was rounded."""
CLOSE = 0.85
"""Mean use of the possible adhesion that counts as "very close"."""
SUBOPTIMAL = 0.02
"""Difference of mean uses from which on one is lower than the other."""
CHATTERING = 1.5
"""Rms of fast changes of adhesion after 25 s over that before, from which on chattering is "significant"."""
OVER = 0.1
"""Longest time above the limit of adhesion [s] that counts as adherence: the limit acts after estimate and lag."""
LOCK = 0.2
"""Time up to which a wheelset that stands above 2 m/s touches, and does not lock [s]."""
HOLDS = 0.75
"""Share of repeats in which a required sentence must hold."""
PROMISING = 0.06
"""Largest error of distances up to which the course of adhesion is judged."""

REQUIRED: Mapping[str, Callable[[Mapping[str, float]], bool]] = {
    "close": lambda course: min(course["used_before"], course["used_after"]) >= CLOSE,
    "suboptimal": lambda course: (
        course["used_coupled"] <= min(course["used_before"], course["used_after"]) - SUBOPTIMAL
    ),
    "limited": lambda course: course["over"] <= OVER,
    "unlocked": lambda course: course["lock"] <= LOCK,
}
"""Sentence that the search requires → function of the numbers of `course_numbers` that returns whether it holds."""

DEFAULT = Candidate(k_A=1.0, k_S=0.4, A=0.4, B=0.6, filter_time=0.0042, slip_small=0.003)
"""The published shape of the scenarios, Polach's dry one, and the filter of this project's law."""

# Bounds: k_A ≤ 1 and the range of k_S/k_A are those of published sets (Polach, 2005; Mal et al., 2020); published A are
# 0.1 to 0.5, B 0.1 to 0.6 s/m, widened on either side. The filter is between one sample of the controller and the
# time in which the rail changes; the threshold below all peaks.
BOUNDS: Mapping[str, tuple[float, float]] = {
    "k_A": (0.03, 1.0),
    "k_S/k_A": (1 / 3, 1.0),
    "A": (0.05, 0.8),
    "B": (0.05, 1.5),
    "filter_time": (1e-3, 0.1),
    "slip_small": (3e-4, 0.02),
}
_LINEAR = ("A",)


def candidate_at(point: Sequence[float]) -> Candidate:
    """Return the candidate at a point of the unit cube, axes in the order of `BOUNDS`."""
    values: dict[str, float] = {}
    for (name, (low, high)), share in zip(BOUNDS.items(), point, strict=True):
        values[name] = low * (high / low) ** share if name not in _LINEAR else low + (high - low) * share
    ratio = values.pop("k_S/k_A")
    # Rounded to the four digits that files have, so that a distance can be reproduced from a file.
    return Candidate(k_S=_round(ratio * values["k_A"]), **{name: _round(value) for name, value in values.items()})


def _round(value: float) -> float:
    return float(f"{value:.4g}")


def rail_of(name: str, candidate: Candidate, level: float) -> dict[str, Any]:
    """Return the changes that give a scenario a candidate's creep curve and a level of friction.

    The clean rail of the conditioning has the same level, so that wheelsets clean the rail as in the scenario file.
    """
    recovered = _clean(name)
    return {
        "adhesion.polach": candidate.polach,
        "adhesion.level": level,
        "adhesion.conditioning.recovered": round(level * recovered, 5),
    }


@dataclass(frozen=True, slots=True, kw_only=True)
class TextRail:
    """Rail and brakes that agree with the text: adhesion reaches the limit of 0.15 after the last rise of friction.

    Attributes:
        top: Highest friction of the trapezoid, which levels do not scale.
        low: Time of low friction in each period [s].
        brake: Adhesion that the full brake of each group demands, at nominal pad friction.
    """

    top: float
    low: float
    brake: float

    def changes(self, level: float) -> dict[str, Any]:
        """Return the changes of the trapezoid, whose rises begin at the same instants as in the scenario file."""
        return {
            "adhesion.maximum": round(self.top / level, 5),
            "adhesion.low": f"{self.low:g} s",
            "adhesion.first_fall": f"{_FALL_AND_LOW - self.low:g} s",
            "vehicle.parameters": {"p_max": list(pressures_of(self.brake))},
        }


_FALL_AND_LOW = 8.0
"""Sum of `first_fall` and `low` of the trapezoid [s], on which the instants of its rises depend."""


@cache
def pressures_of(brake: float) -> tuple[float, ...]:
    """Return the highest cylinder pressures [Pa] with which each group's full brake demands an adhesion."""
    nominal = VehicleData(Scenario.load("trapezoid")).nominal
    friction = nominal.parameters["mu_b_nominal[1]"]
    pressures: list[float] = []
    for one in nominal.formation.brakes:
        assert one is not None, "the plants of the paper show their brakes"
        force = brake * one.load * one.wheel_radius / (one.units * one.friction_radius * friction)
        pressures.append(round(one.pressure_of(force), -3))
    return tuple(pressures)


@cache
def _clean(name: str) -> float:
    conditioning = Scenario.load(name).adhesion.conditioning
    if conditioning is None:
        raise ValueError(f"{name}: [adhesion.conditioning] is missing; the rises of friction to the rear need it")
    return conditioning.recovered


def law_of(candidate: Candidate) -> dict[str, Any]:
    """Return the changes that select the law as printed with a candidate's parameters."""
    parameters = {
        "filter_time": candidate.filter_time,
        "slip_small": candidate.slip_small,
        "adhesion_small": ADHESION_SMALL,
    }
    return {"controller.kind": "adhesion_literal", "controller.parameters": parameters}


ADHESION_SMALL = 0.015
"""Estimated adhesion below which the wheel counts as rolling: chosen, not searched."""


def stop_of(
    name: str,
    candidate: Candidate,
    level: float,
    controller: str,
    seed: int | None = None,
    of_text: TextRail | None = None,
) -> Scenario:
    """Return a scenario with a candidate's creep curve and one of the two controllers; perturbed by a seed."""
    slip_based = {"controller.kind": "slip_two_state", "estimator.kind": "none"}
    changes = rail_of(name, candidate, level) | (slip_based if controller == "sbc" else law_of(candidate))
    if of_text is not None:
        changes |= of_text.changes(level)
    if seed is not None:
        changes["vehicle.nudge"] = {"relative": PERTURBATION, "seed": seed}
    return Scenario.load(name, changes)


SPEED, LOAD = 80 / 3.6, 137e3
"""Initial speed [m/s] and load of a wheelset [N] at which creep curves are drawn and judged."""
SLIPS = np.geomspace(1e-3, 1.0, 200)


def creep_curve(candidate: Candidate, friction: float) -> NDArray[np.float64]:
    """Return the adhesion at `SLIPS` for a maximum friction, at `SPEED` and `LOAD`."""
    same = np.ones(SLIPS.size)
    contact = VehicleData(Scenario.load("plain", {"adhesion.polach": candidate.polach})).contact
    return contact(SLIPS, SPEED * same, LOAD * same, friction * same)


def share_of(candidate: Candidate, friction: float) -> float:
    """Return the adhesion at 15 % slip over the maximum."""
    curve = creep_curve(candidate, friction)
    return float(np.interp(0.15, SLIPS, curve) / curve.max())


def mean_friction(level: float) -> float:
    """Return the mean of the lowest and the highest friction of the trapezoid at a level."""
    trapezoid: Any = Scenario.load("trapezoid").adhesion
    return level * (trapezoid.minimum + trapezoid.maximum) / 2


def median_distance(name: str, candidate: Candidate, level: float, controller: str, repeats: int) -> float:
    """Return the median distance of perturbed stops [m]; a stop without standstill counts as infinite."""
    distances = [braking_distance(stop_of(name, candidate, level, controller, seed)) for seed in range(1, repeats + 1)]
    return float(np.median([math.inf if distance is None else distance for distance in distances]))


def fit(candidate: Candidate) -> CandidateFit:
    """Solve for the levels, and return both controllers' distances at them."""
    levels: dict[str, float] = {}
    for name in SCENARIOS:
        levels[name] = level = _level(name, candidate, _GUESSES[name] * levels.get(SCENARIOS[0], 1.0))
        if math.isnan(level):
            none = dict.fromkeys(SCENARIOS, math.nan)
            return CandidateFit(candidate=candidate, levels=none, sbc=none, abc=none, share=math.nan, holds=UNKNOWN)
    single = at_levels(candidate, levels, dict.fromkeys(SEARCHED, 1))
    return single if single.largest > 2 * PROMISING else at_levels(candidate, levels, SEARCHED)


def at_levels(candidate: Candidate, levels: Mapping[str, float], repeats: Mapping[str, int]) -> CandidateFit:
    """Return both controllers' distances at given levels, medians over a number of repeats for each controller."""
    sbc, abc = (
        {name: median_distance(name, candidate, levels[name], controller, count) for name in SCENARIOS}
        for controller, count in repeats.items()
    )
    share = share_of(candidate, mean_friction(levels["trapezoid"]))
    found = CandidateFit(candidate=candidate, levels=levels, sbc=sbc, abc=abc, share=share, holds=UNKNOWN)
    if found.largest > PROMISING:
        return found
    courses = repeat_trapezoid(candidate, levels["trapezoid"], repeats["abc"])
    return replace(found, holds={name: float(np.mean([*map(holds, courses)])) for name, holds in REQUIRED.items()})


def repeat_trapezoid(
    candidate: Candidate, level: float, repeats: int, of_text: TextRail | None = None
) -> list[dict[str, float]]:
    """Return `course_numbers` of perturbed stops with the law as printed on the trapezoid, by seed from 1 on."""
    scenarios = [stop_of("trapezoid", candidate, level, "abc", seed, of_text) for seed in range(1, repeats + 1)]
    return [course_numbers(run_stop(scenario)) for scenario in scenarios]


def run_on_rail_of_text(candidate: Candidate, of_text: TextRail, repeats: int) -> dict[str, Any]:
    """Return level, and `repeat_trapezoid` at it, on a rail of the text; the level is NaN if none was found."""
    level = _level("trapezoid", candidate, _GUESSES["trapezoid"], of_text)
    courses = [] if math.isnan(level) else repeat_trapezoid(candidate, level, repeats, of_text)
    return {"level": level, "courses": courses}


def course_numbers(stop: Stop) -> dict[str, float]:
    """Return distance [m] and those numbers of `course_of_adhesion` on which sentences depend, by name."""
    course = course_of_adhesion(stop)
    numbers = {"distance": stop.metrics.distance} | {f"used_{part}": used for part, used in course["used"].items()}
    numbers |= dict(zip(("chatter_before", "chatter_after"), course["chatter"], strict=True))
    return numbers | {name: course[name] for name in ("duration", "peak", "over", "lock", "lowest_group")}


UNKNOWN: Mapping[str, float] = dict.fromkeys(REQUIRED, math.nan)


def _level(name: str, candidate: Candidate, guess: float, of_text: TextRail | None = None) -> float:
    # Secants between the logarithms of level and distance. A distance is nearly proportional to 1/level if the level
    # scales the whole course, and to a power of it if the highest friction is given.
    usual = -1.0 if of_text is None else -0.6
    tried: dict[float, float] = {}
    level = guess
    for _ in range(_SECANTS):
        distance = braking_distance(stop_of(name, candidate, level, "sbc", of_text=of_text))
        # A stop that ends at the horizon means that the rail is far too slippery.
        tried[level] = math.log((4 * SBC[name] if distance is None else distance) / SBC[name])
        if abs(tried[level]) < _CLOSE:
            return level
        slope = usual
        if len(tried) > 1:
            (first, before), (last, after) = list(tried.items())[-2:]
            slope = (after - before) / math.log(last / first)
        # Chatter may reverse a short secant: then the usual slope is assumed.
        level = round(level * math.exp(-tried[level] / (slope if 3 * usual < slope < 0.3 * usual else usual)), 5)
        if not LEVELS[0] <= level <= LEVELS[1] or level in tried:
            break
    nearest = min(tried, key=lambda level: abs(tried[level]))
    return nearest if abs(tried[nearest]) < _NEAR else math.nan


_SECANTS = 12

STAGES = (24, 16, 16, 16, 16, 16)
"""Candidates of a Sobol sequence over all bounds, then around the best so far, ever closer."""
PARENTS = 6
FIRST_WIDTH = 0.06
"""1σ of the first stage around the best, as a share of the bounds; each next one has two thirds of it."""
_SLIPPERIEST = 0.15
"""Upper bound of the mean friction of scenarios: a curve whose share is too small there is so below, too."""

Point = tuple[float, ...]


def search(
    work: Work, known: Sequence[CandidateFit] = (), stages: Sequence[int] = STAGES, seed: int = 1
) -> list[CandidateFit]:
    """Return all fits of a deterministic search, the best first: Sobol points, then an evolution strategy.

    Only candidates whose creep curve is plausible are tried.

    Args:
        work: Work that runs the fits.
        known: Fits of an earlier search; the search continues from those with a plausible curve, whose levels and
            distances are computed again.
        stages: Number of candidates of each stage.
        seed: Seed of the points.
    """
    sobol, generator, width = qmc.Sobol(len(BOUNDS), rng=seed), np.random.default_rng(seed), FIRST_WIDTH
    points = [point for fit in known if is_plausible(candidate_at(point := point_of(fit.candidate)))]
    first = [tuple(map(float, point)) for point in sobol.random(8 * stages[0])]
    points += [point for point in first if is_plausible(candidate_at(point))][: stages[0]]
    fits = dict(zip(points, work.map(fit, [candidate_at(point) for point in points]), strict=True))
    for count in stages[1:]:
        parents = sorted(fits, key=lambda point: fits[point].cost)[:PARENTS]
        children: list[Point] = []
        while len(children) < count:
            parent = np.array(parents[len(children) % len(parents)])
            moved = np.clip(parent + width * generator.standard_normal(len(BOUNDS)), 0, 1)
            child = tuple(map(float, moved))
            if is_plausible(candidate_at(child)):
                children.append(child)
        fits |= dict(zip(children, work.map(fit, [candidate_at(point) for point in children]), strict=True))
        width *= 2 / 3
    return sorted(fits.values(), key=lambda fit: fit.cost)


def is_plausible(candidate: Candidate) -> bool:
    """Return whether a creep curve may be plausible at some level of friction, before levels are known."""
    return share_of(candidate, _SLIPPERIEST) >= SHARE


def point_of(candidate: Candidate) -> Point:
    """Return the point of the unit cube nearest to a candidate: the inverse of `candidate_at`."""
    shares: list[float] = []
    for name, (low, high) in BOUNDS.items():
        value = value_of(candidate, name)
        share = math.log(value / low) / math.log(high / low) if name not in _LINEAR else (value - low) / (high - low)
        shares.append(min(1.0, max(0.0, share)))
    return tuple(shares)


def value_of(candidate: Candidate, name: str) -> float:
    """Return one of the numbers of `BOUNDS` of a candidate."""
    return candidate.k_S / candidate.k_A if name == "k_S/k_A" else float(getattr(candidate, name))


def refine(work: Work, fits: Sequence[CandidateFit], count: int = 4) -> CandidateFit:
    """Return the best of the first few fits by the medians of `FINAL` repeats."""
    again = work.map(call, [partial(at_levels, fit.candidate, fit.levels, FINAL) for fit in fits[:count]])
    return min(again, key=lambda fit: (not fit.is_admissible, fit.cost))


def write_fits(path: Path, fits: Sequence[CandidateFit]) -> None:
    """Write fits as CSV, one per line."""
    with replacing(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        distances = (f"{kind}_{name}" for kind in ("level", "sbc", "abc") for name in SCENARIOS)
        writer.writerow([*_NUMBERS, *distances, "share", *REQUIRED])
        for fit in fits:
            numbers = [getattr(fit.candidate, name) for name in _NUMBERS]
            distances = [round(values[name], 2) for values in (fit.sbc, fit.abc) for name in SCENARIOS]
            holds = [round(fit.holds[name], 4) for name in REQUIRED]
            levels = [fit.levels[name] for name in SCENARIOS]
            writer.writerow([*numbers, *levels, *distances, round(fit.share, 4), *holds])


def read_fits(path: Path) -> list[CandidateFit]:
    """Return the fits in a file that `write_fits` wrote."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    return [
        CandidateFit(
            candidate=Candidate(**{name: row[name] for name in _NUMBERS}),
            levels={name: row[f"level_{name}"] for name in SCENARIOS},
            sbc={name: row[f"sbc_{name}"] for name in SCENARIOS},
            abc={name: row[f"abc_{name}"] for name in SCENARIOS},
            share=row["share"],
            holds={name: row[name] for name in REQUIRED},
        )
        for row in rows
    ]


_NUMBERS = ("k_A", "k_S", "A", "B", "filter_time", "slip_small")
