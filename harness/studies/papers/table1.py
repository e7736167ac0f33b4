"""Identification of creep curve, rails and law from Table 1 of Schwarz, Posielek and Goetjes (2021) and its text.

The paper publishes neither its creep curve nor brake forces, filter and threshold of its law, and friction only as a
figure. `BOUNDS` are the numbers that are free here; six distances and the sentences on the results are known. For each
candidate three levels of friction, one for each scenario, are solved for, so that slip-based control stops in the
published distances. Candidates are judged by the three distances of the law as printed and by `REQUIRED`, sentences
that must hold in most of the same stops. The law chatters, so that each stop is repeated with perturbed parameters.
"""

import csv
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache, partial
from pathlib import Path

import numpy as np
import pandas
from numpy.typing import NDArray

from railgrip.api import Scenario
from railgrip.base.files import write_text
from railgrip.base.tables import TomlTable
from railgrip.campaign.work import Work, call
from railgrip.report.statistics import endless
from railgrip.report.stop import Stop
from railgrip.simulate.run import braking_distance, run_stop
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.studies.papers.courses import LIMIT, course_of_adhesion

SCENARIOS: tuple[str, ...] = ("trapezoid", "sine_sweep", "random")
SBC = {"trapezoid": 382.9, "sine_sweep": 316.2, "random": 339.6}
"""Table 1, braking distances of slip-based control [m]."""
ABC = {"trapezoid": 333.4, "sine_sweep": 286.6, "random": 309.6}
"""Table 1, braking distances of adhesion-based control [m]."""

PERTURBATION = 1e-5
"""Perturbation of all parameters of the plant in repeats: as much as its solver may err in a step, by its tolerance. A
fit that holds only for smaller perturbations depends on the solver."""
SEARCHED: Mapping[str, int] = {"sbc": 1, "abc": 3}
"""Repeats of a stop in the search: a steady fit differs by 0.1 % between repeats, others by several percent."""
FINAL: Mapping[str, int] = {"sbc": 5, "abc": 21}
"""Repeats of a stop of the result; an odd number, so that the median is a stop."""

LEVELS = (0.5, 2.5)
"""Range in which a level is searched, a factor on the friction of the scenario file."""
_CLOSE, _NEAR = 5e-4, 3e-3  # relative tolerances of a distance: below the effect of rounding; and at a jump
_GUESSES = {"trapezoid": 1.0, "sine_sweep": 1.24, "random": 1.22}
"""Start of the search for a level: of the trapezoid, and of the others relative to that of the trapezoid."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """The free numbers, for which levels are solved: creep curve, law, rails and brakes.

    Attributes:
        k_A, k_S, A, B: Of the creep curve; B in s/m.
        filter_time, slip_small: Filter [s] and threshold of the law.
        contrast: High over low friction of the trapezoid, before its last rise.
        top: Friction after that rise, which levels do not scale.
        ramp: Duration of a rise or fall of the trapezoid [s].
        deviation: Standard deviation of the random friction.
        brake: Adhesion that the full brake of each group demands, at nominal pad friction.
    """

    k_A: float  # noqa: N815 (the name in the literature)
    k_S: float  # noqa: N815 (the name in the literature)
    A: float
    B: float
    filter_time: float
    slip_small: float
    contrast: float
    top: float
    ramp: float
    deviation: float
    brake: float

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
        lacking = {f"adhesion at 15 % slip ≥ {100 * SHARE:.0f} % of the greatest": SHARE - self.share}
        lacking |= {name: HOLDS - self.holds[name] for name in REQUIRED}
        return {name: math.inf if math.isnan(value) else max(0.0, value) for name, value in lacking.items()}

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

SIMILAR = 0.85
"""Mean use of the possible adhesion by each group from which on its wheelsets are like the first one."""
LONGER = (1.5, 2.5)
"""Time by which slip-based control takes longer that is "approximately 2 s" [s]."""

REQUIRED: Mapping[str, Callable[[Mapping[str, float]], bool]] = {
    "close": lambda course: min(course["used_before"], course["used_after"]) >= CLOSE,
    "limited": lambda course: course["over"] <= OVER,
    "active": lambda course: course["peak"] >= LIMIT,
    "unlocked": lambda course: course["lock"] <= LOCK,
    "chattering": lambda course: course["chatter_after"] >= CHATTERING * course["chatter_before"],
    "longer": lambda course: LONGER[0] <= course["longer"] <= LONGER[1],
    "similar": lambda course: course["lowest_group"] >= SIMILAR,
}
"""Sentence that the search requires → function of the numbers of `course_numbers` that returns whether it holds."""


def is_suboptimal(course: Mapping[str, float]) -> bool:
    """Return whether adhesion is lower from 9 to 16 s, a sentence that the search does not require."""
    return course["used_coupled"] <= min(course["used_before"], course["used_after"]) - SUBOPTIMAL


DEFAULT = Candidate(
    k_A=1.0, k_S=0.4, A=0.4, B=0.6, filter_time=0.0042, slip_small=0.003, contrast=0.13 / 0.055, top=0.13, ramp=1.0,
    deviation=0.02, brake=0.134,
)  # fmt: skip
"""The library's scenarios: Polach's dry curve, the filter of this project's law, the brakes of the motor bogies."""

# Bounds: k_A ≤ 1 and the range of k_S/k_A are those of published sets (Polach, 2005; Mal et al., 2020); published A are
# 0.1 to 0.5, B 0.1 to 0.6 s/m, widened on either side. The filter is between one sample of the controller and the
# time in which the rail changes; the threshold below all peaks. Adhesion reaches 0.15 after the last rise, so that
# friction and full brakes are at least about that. Ramps leave two seconds between a rise and the next fall.
BOUNDS: Mapping[str, tuple[float, float]] = {
    "k_A": (0.03, 1.0),
    "k_S/k_A": (1 / 3, 1.0),
    "A": (0.05, 0.8),
    "B": (0.05, 1.5),
    "filter_time": (1e-3, 0.1),
    "slip_small": (3e-4, 0.02),
    "contrast": (1.2, 2.5),
    "top": (0.155, 0.2),
    "ramp": (0.5, 3.0),
    "deviation": (0.005, 0.03),
    "brake": (0.145, 0.2),
}
_LINEAR = ("A", "top", "brake")


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


LOW = 0.075
"""Low friction of the trapezoid at a level of 1; the level scales it."""
_RISES, _FALL_AND_LOW = (9.0, 17.0, 25.0), 5.0
"""Begins of the rises of the trapezoid, and time from a fall to the next rise [s]: those of the scenario file."""


def rail_of(name: str, candidate: Candidate, level: float) -> TomlTable:
    """Return the changes that give a scenario a candidate's creep curve, rail and brakes, and a level of friction.

    The clean rail of the conditioning has the same level, so that wheelsets clean the rail as in the scenario file.
    Controller and plant have the same full brakes: a controller demands at most the pressure that it knows.
    """
    conditioning = _conditioning(name)
    rail: TomlTable = {"polach": candidate.polach, "level": level}
    rail["conditioning"] = conditioning | {"recovered": round(level * conditioning["recovered"], 5)}
    if name == "trapezoid":
        rail |= {"kind": "points", "over": "time", "points": _steps(candidate, level)}
        changes: TomlTable = {"adhesion": rail}
    else:
        changes = {f"adhesion.{key}": value for key, value in rail.items()}
    if name == "random":
        changes["adhesion.deviation"] = candidate.deviation
    full = {f"p_max[{group}]": value for group, value in enumerate(pressures_of(candidate.brake), start=1)}
    return changes | {"vehicle.parameters": full, "controller.parameters": full}


def _steps(candidate: Candidate, level: float) -> list[tuple[str, float]]:
    """Return the points of the trapezoid, whose falls and rises begin at the same instants as in the scenario file."""
    high, ramp = round(candidate.contrast * LOW, 5), candidate.ramp
    points = [(0.0, high)]
    for rise in _RISES:
        fall = rise - _FALL_AND_LOW
        after = high if rise < _RISES[-1] else round(candidate.top / level, 5)
        points += [(fall, high), (fall + ramp, LOW), (rise, LOW), (rise + ramp, after)]
    return [(f"{time:g} s", friction) for time, friction in points]


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
def _conditioning(name: str) -> TomlTable:
    conditioning = Scenario.load(name).adhesion.conditioning
    if conditioning is None:
        raise ValueError(f"{name}: [adhesion.conditioning] is missing; the rises of friction to the rear need it")
    return {"fraction": conditioning.fraction, "recovered": conditioning.recovered, "by": conditioning.by}


def law_of(candidate: Candidate) -> dict[str, float]:
    """Return the parameters of the law as printed with a candidate's numbers, without the guard at low speed."""
    searched = {name: getattr(candidate, name) for name in ("filter_time", "slip_small")}
    return searched | {"adhesion_small": ADHESION_SMALL, "speed_min": 0.0}


ADHESION_SMALL = 0.015
"""Estimated adhesion below which the wheel counts as rolling: chosen, not searched."""


def stop_of(name: str, candidate: Candidate, level: float, controller: str, seed: int | None = None) -> Scenario:
    """Return a scenario with a candidate's numbers and one of the two controllers; perturbed by a seed."""
    changes = rail_of(name, candidate, level)
    if controller == "sbc":
        changes |= {"controller.kind": "slip_two_state", "estimator.kind": "none"}
    else:
        changes["controller.kind"] = "adhesion_literal"
        changes["controller.parameters"] = changes["controller.parameters"] | law_of(candidate)
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


def mean_friction(candidate: Candidate, level: float) -> float:
    """Return the mean of low and high friction of the trapezoid at a level, before its last rise."""
    return level * LOW * (1 + candidate.contrast) / 2


def median_distance(name: str, candidate: Candidate, level: float, controller: str, repeats: int) -> float:
    """Return the median distance of perturbed stops [m]; a stop without standstill counts as infinite."""
    stops = (stop_of(name, candidate, level, controller, seed) for seed in range(1, repeats + 1))
    return float(np.median([endless(braking_distance(stop)) for stop in stops]))


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
    share = share_of(candidate, mean_friction(candidate, levels["trapezoid"]))
    found = CandidateFit(candidate=candidate, levels=levels, sbc=sbc, abc=abc, share=share, holds=UNKNOWN)
    if found.largest > PROMISING:
        return found
    courses = repeat("trapezoid", candidate, levels["trapezoid"], repeats["abc"])
    return replace(found, holds={name: float(np.mean([*map(holds, courses)])) for name, holds in REQUIRED.items()})


def repeat(name: str, candidate: Candidate, level: float, repeats: int) -> list[dict[str, float]]:
    """Return `course_numbers` of perturbed stops with the law as printed, by seed from 1 on."""
    slip_based = run_stop(stop_of(name, candidate, level, "sbc")).metrics.duration
    stops = [run_stop(stop_of(name, candidate, level, "abc", seed)) for seed in range(1, repeats + 1)]
    return [course_numbers(stop) | {"longer": slip_based - stop.metrics.duration} for stop in stops]


def course_numbers(stop: Stop) -> dict[str, float]:
    """Return distance [m] and those numbers of `course_of_adhesion` on which sentences depend, by name."""
    course = course_of_adhesion(stop)
    numbers = {"distance": stop.metrics.distance} | {f"used_{part}": used for part, used in course["used"].items()}
    numbers |= dict(zip(("chatter_before", "chatter_after"), course["chatter"], strict=True))
    return numbers | {name: course[name] for name in ("duration", "peak", "over", "lock", "lowest_group")}


UNKNOWN: Mapping[str, float] = dict.fromkeys(REQUIRED, math.nan)


def _level(name: str, candidate: Candidate, guess: float) -> float:
    # Secants between the logarithms of level and distance, which is nearly proportional to 1/level.
    usual = -1.0
    tried: dict[float, float] = {}
    level = guess
    for _ in range(_SECANTS):
        distance = braking_distance(stop_of(name, candidate, level, "sbc"))
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

STAGES = (8, 8, 8, 8)
"""Candidates around the best so far, ever closer: some quarter of an hour of processor time."""
PARENTS = 6
FIRST_WIDTH = 0.06
"""1σ of the first stage, as a share of the bounds; each next one has two thirds of it."""
_SLIPPERIEST = 0.15
"""Upper bound of the mean friction of scenarios: a curve whose share is too small there is so below, too."""

Point = tuple[float, ...]


def search(
    work: Work, known: Sequence[CandidateFit], stages: Sequence[int] = STAGES, seed: int = 1
) -> list[CandidateFit]:
    """Return all fits of a deterministic evolution strategy, the best first.

    Only candidates whose creep curve is plausible are tried. Nearly all other points of the bounds lock wheelsets, so
    that the search begins with fits whose wheelsets do not.

    Args:
        work: Work that runs the fits.
        known: Fits of an earlier search; their levels and distances are computed again.
        stages: Number of candidates of each stage.
        seed: Seed of the points.
    """
    generator, width = np.random.default_rng(seed), FIRST_WIDTH
    points = [point_of(fit.candidate) for fit in known]
    fits = dict(zip(points, work.map(fit, [candidate_at(point) for point in points]), strict=True))
    for count in stages:
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
    rows = [
        {name: getattr(fit.candidate, name) for name in _NUMBERS}
        | {f"level_{name}": fit.levels[name] for name in SCENARIOS}
        | {f"sbc_{name}": round(fit.sbc[name], 2) for name in SCENARIOS}
        | {f"abc_{name}": round(fit.abc[name], 2) for name in SCENARIOS}
        | {"share": round(fit.share, 4)}
        | {name: round(fit.holds[name], 4) for name in REQUIRED}
        for fit in fits
    ]
    write_text(path, pandas.DataFrame(rows).to_csv(index=False, lineterminator="\n", na_rep="nan"))


def read_fits(path: Path) -> list[CandidateFit]:
    """Return the fits in a file that `write_fits` wrote."""

    def by_name(row: Mapping[str, float], names: Iterable[str], kind: str = "") -> dict[str, float]:
        return {name: row[kind + name] for name in names}

    # The parser of pandas may err in the last digit.
    lines = csv.DictReader(path.read_text(encoding="utf-8").splitlines())
    rows = [{name: float(value) for name, value in row.items()} for row in lines]
    return [
        CandidateFit(
            candidate=Candidate(**by_name(row, _NUMBERS)),
            levels=by_name(row, SCENARIOS, "level_"),
            sbc=by_name(row, SCENARIOS, "sbc_"),
            abc=by_name(row, SCENARIOS, "abc_"),
            share=row["share"],
            holds=by_name(row, REQUIRED),
        )
        for row in rows
    ]


_NUMBERS = tuple(field.name for field in fields(Candidate))
