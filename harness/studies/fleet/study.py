"""What a fleet learns from many stops: pads, wheel radii, and the metres that releases of single groups cost.

Releases of single groups are made by hand, as a small modulation, and designed for information on the pads (D-optimal).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from typer import Option

from railgrip.campaign.work import Work
from railgrip.estimation.judge import error_figures, rms
from railgrip.estimators.belief import Matrix, Vector
from railgrip.report.baseline import Finding, mean
from railgrip.report.marked import write_tables
from railgrip.report.page import Page
from railgrip.report.table import ReportTable, share
from railgrip.studies.fleet.trains import Releases, TrainCase, TrainStops, fleet_estimate, train_stops
from railgrip.studies.pad_monitor.evidence import evidence_of, formation
from railgrip.studies.pad_monitor.life import FIRST_SLOT, IN_TURN, SLOT, Life, Release, live
from railgrip.studies.study import Study

PULSE = 0.2e5
"""Drop of the pressure in the modulation [Pa]."""
PULSE_DURATION = 1.0
"""Duration of a pulse [s]."""
CYCLES = 4
"""Pulses of each group in a stop."""

MODULATION: Releases = tuple(
    Release(group=g, start=FIRST_SLOT + (cycle * formation().groups + g) * PULSE_DURATION, duration=PULSE_DURATION,
            drop=PULSE)
    for cycle, g in product(range(CYCLES), range(formation().groups))
)  # fmt: skip
"""Small pulses of each group in turn."""

STARTS = tuple(FIRST_SLOT + slot * SLOT for slot in range(6))
DROPS = (1e5, float("inf"))
CANDIDATES: Releases = tuple(
    Release(group=g, start=start, duration=SLOT, drop=drop)
    for g, start, drop in product(range(formation().groups), STARTS, DROPS)
)
"""Releases from which a design is chosen: each as long as those by hand."""

DESIGN_SEEDS = (901, 902)
"""Trains whose first stop gives the expected information."""

Criterion = Callable[[Releases], float]


@cache
def expected_information(releases: Releases) -> Matrix:
    """Return the Fisher information on the health of each group's pads in a stop, shape (groups, groups).

    It is the mean over a stop of each of the trains in `DESIGN_SEEDS`. A stop's information is the inverse of the
    covariance that the filter of the monitor propagates with the Jacobians of the prediction, without its prior.
    """
    covariances = [
        evidence_of(*next(live(Life(stops=1, seed=seed, releases=releases)))).covariance for seed in DESIGN_SEEDS
    ]
    return np.asarray(np.mean([np.linalg.inv(covariance) for covariance in covariances], axis=0), dtype=np.float64)


def log_determinant(releases: Releases) -> float:
    """Return the logarithm of the determinant of the expected information."""
    return float(np.linalg.slogdet(expected_information(releases))[1])


def design(candidates: Sequence[Release], count: int, criterion: Criterion = log_determinant) -> Releases:
    """Return `count` of the candidates that maximise a criterion, in the order of time.

    Greedy choice, then exchanges of single releases until none improves the criterion: a local maximum.

    Source: Fedorov, Theory of Optimal Experiments (1972), ch. 3; Cook and Nachtsheim, Technometrics 22 (1980) 315.
    """
    chosen: Releases = ()
    for _ in range(count):
        chosen = _best(chosen, candidates, criterion)
    value = criterion(chosen)
    while True:
        for release in chosen:
            chosen = _best(tuple(other for other in chosen if other is not release), candidates, criterion)
        improved = criterion(chosen)
        if improved <= value + 1e-9 * abs(value):
            return chosen
        value = improved


def _best(chosen: Releases, candidates: Sequence[Release], criterion: Criterion) -> Releases:
    sets = (in_order((*chosen, candidate)) for candidate in candidates if candidate not in chosen)
    return max(sets, key=criterion)


def in_order(releases: Sequence[Release]) -> Releases:
    """Return releases in the order of time and group."""
    return tuple(sorted(releases, key=lambda release: (release.start, release.group, release.drop)))


def designed() -> Releases:
    """Return the design with the number of releases that are made by hand."""
    return design(CANDIDATES, len(IN_TURN))


PAGE = Path("docs/papers.md")
"""Relative to the folder of the project, in which the command runs."""

TRAINS, STOPS = 20, 40
QUICK = (4, 5)
HEADLINES = (2, 3)
"""Trains and stops of the whole study, of a quick run and of the headline numbers."""
FIRST_SEED = 301
"""Seed of the first train; no number of the model was chosen on trains with these seeds."""
COUNTS = (1, 5, 10, 20, 40)
"""Stops of each train after which the estimates are compared."""

PULSES = "0.2 bar for 1 s"
"""Name of the modulation in tables."""

TARGET = 0.05
"""Standard deviation to which pads of single groups should be known."""


def release_designs() -> dict[str, Releases]:
    """Return the releases that are compared; the design takes half a minute."""
    return {
        "none": (),
        PULSES: MODULATION,
        "each group in turn": IN_TURN,
        "D-optimal": designed(),
    }


@dataclass(frozen=True)
class FleetStudy(Study):
    """Estimate pads and wheel radii jointly from all stops of a fleet, with releases of single groups or without."""

    write: Annotated[bool, Option("--write", help="Write the tables into docs/papers.md.")] = False
    quick: bool = False

    def page(self, work: Work) -> Page:
        """Return errors, intervals and metres by design of the releases; the small form has few trains and stops."""
        trains, stops = QUICK if self.quick else (TRAINS, STOPS)
        designs = release_designs()
        found = simulate(work, designs, trains, stops)
        tables = {
            "fleet_pads": learned(found, stops),
            "fleet_radii": radii(found, stops),
            "fleet_needed": needed_table(found, stops),
            "fleet_designs": designs_table(designs),
        }
        if self.write:
            write_tables(PAGE, tables)
        needed = stops_needed(found[PULSES], stops)
        return Page(
            title="What a fleet learns from many stops",
            question="After how many stops are the pads of each group known to 5 %, and at which cost in metres?",
            answer=f"Pulses of 0.2 bar make a stop {extra_metres(found, PULSES):.1f} m longer. With them the readings "
            f"of {stops} stops alone determine the pads of {sum(number is not None for number in needed)} of "
            f"{len(needed)} groups to 5 %.",
            template="studies/fleet/fleet.md.jinja",
            values=tables | {"trains": trains, "stops": stops},
            tables={f"{name}.csv": table for name, table in tables.items()},
            screen=tuple(tables.values()),
        )

    def headlines(self, work: Work) -> list[Finding]:
        """Return errors and deviations of the joint estimate from a few stops, and the information of a stop."""
        trains = simulate(work, {"each group in turn": IN_TURN}, *HEADLINES)["each group in turn"]
        groups, estimate = formation().groups, fleet_estimate(trains, HEADLINES[1])
        pads, radii = estimate.trains[:, :groups], estimate.trains[:, -groups:]
        error, of_radii = rms(pads - [train.pads for train in trains]), rms(radii - [train.radii for train in trains])
        return [
            mean("fleet: pad friction RMSE", error),
            mean("fleet: claimed deviation of pad friction", float(estimate.train_deviation[:, :groups].mean())),
            mean("fleet: wheel radius RMSE", of_radii),
            # 2 % of the geometric mean of the variances of four groups.
            Finding("fleet: log det of the information of a stop", log_determinant(IN_TURN), "1", 0.08),
        ]


STUDY = FleetStudy


def simulate(work: Work, designs: Mapping[str, Releases], trains: int, stops: int) -> dict[str, list[TrainStops]]:
    """Return the stops of the same trains with each design of releases."""
    cases = [
        TrainCase(seed=seed, stops=stops, releases=releases)
        for releases in designs.values()
        for seed in range(FIRST_SEED, FIRST_SEED + trains)
    ]
    results = work.map(train_stops, cases)
    return {name: results[i * trains : (i + 1) * trains] for i, name in enumerate(designs)}


def pad_deviation(trains: Sequence[TrainStops], stops: int) -> np.ndarray:
    """Return the claimed deviations of the pads from the readings of each train alone, shape (trains, groups)."""
    alone = [fleet_estimate([train], stops, with_lot=False) for train in trains]
    return np.array([estimate.train_deviation[0, : formation().groups] for estimate in alone])


def stops_needed(trains: Sequence[TrainStops], stops: int) -> list[int | None]:
    """Return, by group, the number of stops after which its pads are known to `TARGET` on average, or None."""
    deviations = np.array([pad_deviation(trains, count).mean(axis=0) for count in range(1, stops + 1)])
    return [int(np.argmax(of_group <= TARGET)) + 1 if of_group[-1] <= TARGET else None for of_group in deviations.T]


def extra_metres(found: Mapping[str, Sequence[TrainStops]], name: str) -> float:
    """Return the mean distance of a stop minus that of the same stop without releases [m]."""
    of_design, without = (np.array([train.distances for train in found[key]]) for key in (name, "none"))
    return float(np.mean(of_design - without))


def _errors(estimated: Matrix, deviation: Matrix, true: Sequence[Vector]) -> dict[str, float]:
    """Return RMSE, mean claimed deviation and coverage of estimates of each train, shapes (trains, n)."""
    figures = error_figures(estimated - np.array(true), deviation)
    return {"RMSE": figures["RMSE"], "claimed": float(deviation.mean()), "coverage of 95 %": figures["coverage"]}


def learned(found: Mapping[str, Sequence[TrainStops]], stops: int) -> ReportTable:
    """Return errors and claimed deviations of the pads by design and number of stops."""
    groups = formation().groups
    rows: list[dict[str, Any]] = []
    for (name, trains), count in product(found.items(), (count for count in COUNTS if count <= stops)):
        estimate = fleet_estimate(trains, count)
        of_pads = estimate.trains[:, :groups], estimate.train_deviation[:, :groups]
        alone = pad_deviation(trains, count).mean(axis=0)
        rows.append(
            {"releases": name, "stops of each train": count, "longer stop": f"{extra_metres(found, name):.1f} m"}
            | _errors(*of_pads, [train.pads for train in trains])
            | {f"group {g + 1} without lot": float(alone[g]) for g in range(groups)}
        )
    numbers = ("RMSE", "claimed", *(f"group {g + 1} without lot" for g in range(groups)))
    forms = {**dict.fromkeys(numbers, "{:.3f}"), "coverage of 95 %": share}
    return ReportTable(rows, forms, ("releases",), title="Pads of single groups over nominal friction")


def radii(found: Mapping[str, Sequence[TrainStops]], stops: int) -> ReportTable:
    """Return errors and claimed deviations of the wheel radii by number of stops, from stops without releases."""
    trains, groups = found["none"], formation().groups
    rows: list[dict[str, Any]] = []
    for count in (count for count in COUNTS if count <= stops):
        estimate = fleet_estimate(trains, count)
        of_radii = estimate.trains[:, -groups:], estimate.train_deviation[:, -groups:]
        errors = _errors(*of_radii, [train.radii for train in trains])
        percent = {name: f"{100 * errors[name]:.3f} %" for name in ("RMSE", "claimed")}
        rows.append({"stops of each train": count} | errors | percent)
    return ReportTable(rows, {"coverage of 95 %": share}, title="Wheel radii over nominal")


def designs_table(designs: Mapping[str, Releases]) -> ReportTable:
    """Return the information that one stop has on the pads, by design of the releases, expected before the stop."""
    groups, by_hand = formation().groups, log_determinant(IN_TURN)
    rows: list[dict[str, Any]] = []
    for name, releases in designs.items():
        deviation = np.sqrt(np.diag(np.linalg.inv(expected_information(releases))))
        ratio = np.exp((by_hand - log_determinant(releases)) / groups)
        rows.append(
            {"releases": name, "log det of the information": log_determinant(releases)}
            | {f"group {g + 1}": float(deviation[g]) for g in range(groups)}
            | {"variance over that by hand": float(ratio)}
        )
    forms = {f"group {g + 1}": "{:.3f}" for g in range(groups)}
    forms |= {"log det of the information": "{:.2f}", "variance over that by hand": "{:.3g}"}
    return ReportTable(rows, forms, ("releases",), title="Expected standard deviation of the pads from one stop")


def needed_table(found: Mapping[str, Sequence[TrainStops]], stops: int) -> ReportTable:
    """Return, by design and group, the number of stops after which the pads are known to `TARGET`, and the metres."""
    rows = [
        {"releases": name, "longer stop": f"{extra_metres(found, name):.1f} m"}
        | {
            f"group {g + 1}": f"more than {stops}" if needed is None else str(needed)
            for g, needed in enumerate(stops_needed(trains, stops))
        }
        for name, trains in found.items()
    ]
    return ReportTable(rows, left=("releases",), title=f"Stops until pads are known to {100 * TARGET:.0f} %")
