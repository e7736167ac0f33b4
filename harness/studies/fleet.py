"""What a fleet learns from many stops: pads, wheel radii and load, and releases designed for information.

A simulated fleet is estimated jointly. A train's quantities θ deviate from the means μ of their lots, those of one stop
x from θ, and a stop estimates

    y = A x + B o + e,   x = θ + δ,   θ = L μ + d,

with deviations d of the trains, scatter δ from stop to stop, transducer offsets o that each train keeps, and the error
e with the covariance of the stop's own estimate. All are Gaussian, so that the posterior of μ, θ and o is exact.

Releases of single groups are made by hand, as a small modulation, and designed for information on the pads (D-optimal).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import xarray
from typer import Option

from railgrip.base.arrays import generator
from railgrip.campaign.work import Work
from railgrip.estimation.judge import error_figures, rms
from railgrip.estimation.models import model_of
from railgrip.estimators.belief import Matrix, Vector
from railgrip.recording.samples import period_of, reading_of, truth_of
from railgrip.report.baseline import Finding, mean
from railgrip.report.page import Page
from railgrip.report.table import ReportTable, share, write_tables
from railgrip.studies.pad_monitor.evidence import MODEL, evidence_of, formation
from railgrip.studies.pad_monitor.life import (
    COASTING,
    FIRST_SLOT,
    IN_TURN,
    LOAD_DEVIATION,
    LOT_DEVIATION,
    SCALE_DEVIATION,
    SLOT,
    Life,
    Release,
    first_health,
    live,
)
from railgrip.studies.study import Study


@dataclass(frozen=True, slots=True, kw_only=True)
class Hierarchy:
    """Prior of a fleet with n quantities of a train, q lots and c transducers of a train.

    Attributes:
        lots: Quantities of a train that have the mean of a lot, the matrix L, shape (n, q).
        lot_mean: Prior mean of μ, shape (q,).
        lot_deviation: Prior standard deviation of μ, shape (q,).
        train_deviation: Standard deviation of d, shape (n,); 0 for a quantity that all trains share.
        stop_deviation: Standard deviation of δ, shape (n,).
        offset_deviation: Standard deviation of o, shape (c,).
    """

    lots: Matrix
    lot_mean: Vector
    lot_deviation: Vector
    train_deviation: Vector
    stop_deviation: Vector
    offset_deviation: Vector


@dataclass(frozen=True, slots=True, kw_only=True)
class StopEstimate:
    """Estimate from one stop.

    Attributes:
        train: Index of the train, from 0.
        mean: y, shape (m,).
        covariance: Covariance of e, shape (m, m).
        of_quantities: A, shape (m, n).
        of_offsets: B, shape (m, c).
    """

    train: int
    mean: Vector
    covariance: Matrix
    of_quantities: Matrix
    of_offsets: Matrix


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetEstimate:
    """Posterior means and standard deviations.

    Attributes:
        lot: Means of the lots, shape (q,), with `lot_deviation`.
        trains: Quantities of each train, shape (trains, n), with `train_deviation`.
        offsets: Offsets of each train's transducers, shape (trains, c), with `offset_deviation`.
    """

    lot: Vector
    lot_deviation: Vector
    trains: Matrix
    train_deviation: Matrix
    offsets: Matrix
    offset_deviation: Matrix


def estimate_fleet(stops: Sequence[StopEstimate], hierarchy: Hierarchy, trains: int) -> FleetEstimate:
    """Return the posterior given all stops; their order does not matter.

    Source: Lindley and Smith, Bayes Estimates for the Linear Model, J. Royal Statistical Society B 34 (1972) 1.
    """
    (n, q), c = hierarchy.lots.shape, hierarchy.offset_deviation.size
    mean, covariance = _prior(hierarchy, trains)
    scatter = np.diag(hierarchy.stop_deviation**2)
    for stop in stops:
        first = q + stop.train * (n + c)
        columns = slice(first, first + n + c)
        design = np.hstack([stop.of_quantities, stop.of_offsets])
        noise = stop.covariance + stop.of_quantities @ scatter @ stop.of_quantities.T
        cross = covariance[:, columns] @ design.T
        gain = np.linalg.solve(design @ cross[columns] + noise, cross.T).T
        mean = mean + gain @ (stop.mean - design @ mean[columns])
        covariance = covariance - gain @ cross.T
        covariance = 0.5 * (covariance + covariance.T)
    deviation = np.sqrt(np.diag(covariance))
    by_train = mean[q:].reshape(trains, n + c)
    by_train_deviation = deviation[q:].reshape(trains, n + c)
    return FleetEstimate(
        lot=mean[:q],
        lot_deviation=deviation[:q],
        trains=by_train[:, :n],
        train_deviation=by_train_deviation[:, :n],
        offsets=by_train[:, n:],
        offset_deviation=by_train_deviation[:, n:],
    )


def _prior(hierarchy: Hierarchy, trains: int) -> tuple[Vector, Matrix]:
    """Return mean and covariance of μ and of θ and o of each train, in this order."""
    c = hierarchy.offset_deviation.size
    to_train = np.vstack([hierarchy.lots, np.zeros((c, hierarchy.lot_mean.size))])
    from_lot = np.vstack([np.eye(hierarchy.lot_mean.size), np.tile(to_train, (trains, 1))])
    own = np.concatenate([hierarchy.train_deviation, hierarchy.offset_deviation])
    apart = np.concatenate([np.zeros(hierarchy.lot_mean.size), np.tile(own, trains)])
    return from_lot @ hierarchy.lot_mean, (from_lot * hierarchy.lot_deviation**2) @ from_lot.T + np.diag(apart**2)


Releases = tuple[Release, ...]

RADIUS_DEVIATION = 0.01
"""Standard deviation of the wheel radius of a group, from train to train, over the nominal radius."""

RADIUS_NOISE = 1e-3
"""Standard deviation of the rolling radius from the readings while coasting, besides the scale of the speed."""

PAD_SCATTER = 0.025
"""Standard deviation of pad friction from stop to stop: units and weather."""

LARGEST_DEVIATION = 0.3
"""Largest standard deviation of a combination of groups that counts. Larger ones rest on the onset of the brake alone,
where the errors of the model exceed the noise."""

_UNKNOWN = 1.0
"""Standard deviation of pads about which nothing is known but the readings."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainCase:
    """A train of the fleet.

    Attributes:
        seed: Seed of its life.
        stops: Number of stops.
        releases: Releases in every stop.
    """

    seed: int
    stops: int
    releases: Releases


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainStops:
    """Simulated stops of a train.

    Attributes:
        estimates: Estimates of the stops as of a train with index 0.
        distances: Distance of each stop [m].
        pads: True friction of each group over the nominal one, shape (groups,).
        radii: True wheel radius of each group over the nominal one, minus 1, shape (groups,).
    """

    estimates: tuple[StopEstimate, ...]
    distances: tuple[float, ...]
    pads: Vector
    radii: Vector


def train_stops(case: TrainCase) -> TrainStops:
    """Simulate the stops of a train and estimate from each."""
    radii = RADIUS_DEVIATION * generator(case.seed, "fleet.radii").standard_normal(formation().groups)
    # The wear of a life of 200 stops; only the first stops are simulated.
    life = Life(stops=200, seed=case.seed, releases=case.releases, radii=tuple((1.0 + radii).tolist()))
    stops = list(live(life, range(case.stops)))
    return TrainStops(
        estimates=tuple(stop_estimate(recording, temperature) for recording, temperature in stops),
        distances=tuple(float(truth_of(recording, "speed").sum() * period_of(recording)) for recording, _ in stops),
        pads=first_health(life),
        radii=radii,
    )


def stop_estimate(recording: xarray.Dataset, temperature: Vector) -> StopEstimate:
    """Return the estimate from a stop: the pads by the monitor's filter, and the rolling radii while coasting.

    Quantities are pad friction of each group over nominal, load minus 1, scale of the speed reading minus 1, and wheel
    radius of each group minus 1. A load above the assumed one and a larger wheel make pads seem worse. Offsets are
    those of the pressure transducers, in standard deviations. Of the pads, only combinations of groups that the stop
    determines are used (`LARGEST_DEVIATION`).
    """
    evidence, groups = evidence_of(recording, temperature), formation().groups
    health, identity = evidence.health, np.eye(groups)
    coasting = slice(0, round(COASTING / period_of(recording)))
    speed = float(np.nanmean(reading_of(recording, "speed")[coasting]))
    wheels = [float(np.nanmean(reading_of(recording, f"wheelset_speed[{g + 1}]")[coasting])) for g in range(groups)]
    radius = speed / np.array(wheels) / _assumed_radius() - 1.0
    variance, directions = np.linalg.eigh(evidence.covariance)
    known = variance < LARGEST_DEVIATION**2
    variance, rows = variance[known], directions[:, known].T
    # Derivatives at nominal health: at the estimated one, stops that underestimate would have larger weights.
    of_pads = rows @ np.column_stack([identity, -np.ones(groups), np.ones(groups), -identity])
    of_radii = np.column_stack([np.zeros((groups, groups + 1)), np.ones(groups), identity])
    # A pressure that reads too high makes pads look worse; its effect is that at nominal health, too. At the estimated
    # one it follows the scatter of the stops, which offsets then seem to explain: all pads become 2 % too low.
    of_offsets = -rows * (evidence.offset / health)
    return StopEstimate(
        train=0,
        mean=np.concatenate([rows @ health, radius]),
        covariance=np.diag([*variance, *[RADIUS_NOISE**2] * groups]),
        of_quantities=np.vstack([of_pads, of_radii]),
        of_offsets=np.vstack([of_offsets, np.zeros((groups, groups))]),
    )


@cache
def _assumed_radius() -> float:
    return next(parameter.start for parameter in model_of(MODEL).parameters if parameter.name == "r_wheel")


def hierarchy(*, with_lot: bool = True) -> Hierarchy:
    """Return the prior of the fleet: all pads are of one lot, all wheels of another, loads and scales have no lot.

    Args:
        with_lot: Whether the deviation of the pads within their lot is known; otherwise only readings inform on them.
    """
    groups, pads = formation().groups, LOT_DEVIATION if with_lot else _UNKNOWN
    lots: Matrix = np.zeros((2 * groups + 2, 2))
    lots[:groups, 0] = lots[groups + 2 :, 1] = 1.0
    return Hierarchy(
        lots=lots,
        lot_mean=np.array([1.0, 0.0]),
        lot_deviation=np.array([0.1, 0.02]),
        train_deviation=np.array([*[pads] * groups, 0.0, 0.0, *[RADIUS_DEVIATION] * groups]),
        stop_deviation=np.array([*[PAD_SCATTER] * groups, LOAD_DEVIATION, SCALE_DEVIATION, *[0.0] * groups]),
        offset_deviation=np.ones(groups),
    )


def fleet_estimate(trains: Sequence[TrainStops], stops: int, *, with_lot: bool = True) -> FleetEstimate:
    """Return the joint estimate from the first stops of every train; see `hierarchy`."""
    of_trains = [replace(one, train=i) for i, train in enumerate(trains) for one in train.estimates[:stops]]
    return estimate_fleet(of_trains, hierarchy(with_lot=with_lot), len(trains))


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
FEW = (2, 3)
"""Trains and stops of the whole study, and of its quick form and headline numbers."""
FIRST_SEED = 301
"""Seed of the first train; no number of the model was chosen on trains with these seeds."""
COUNTS = (1, 5, 10, 20, 40)
"""Stops of each train after which the estimates are compared."""

PULSES = "0.2 bar for 1 s"
"""Name of the modulation in tables."""

TARGET = 0.05
"""Standard deviation to which pads of single groups should be known."""


HAND_MADE: Mapping[str, Releases] = {"none": (), PULSES: MODULATION, "each group in turn": IN_TURN}
"""Releases that are compared with the designed ones."""


@dataclass(frozen=True)
class FleetStudy(Study, quick="2 trains of 3 stops, and no designed releases"):
    """Estimate pads and wheel radii jointly from all stops of a fleet, with releases of single groups or without."""

    write: Annotated[bool, Option("--write", help="Write the tables into docs/papers.md.")] = False

    def page(self, work: Work) -> Page:
        """Return errors, intervals and metres by design of the releases; the small form has few trains and stops."""
        trains, stops = FEW if self.quick else (TRAINS, STOPS)
        # The design takes half a minute.
        designs = HAND_MADE if self.quick else {**HAND_MADE, "D-optimal": designed()}
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
            template="studies/fleet.md.jinja",
            values=tables | {"trains": trains, "stops": stops},
            tables={f"{name}.csv": table for name, table in tables.items()},
            screen=tuple(tables.values()),
        )

    def headlines(self, work: Work) -> list[Finding]:
        """Return errors and deviations of the joint estimate from a few stops, and the information of a stop."""
        trains = simulate(work, {"each group in turn": IN_TURN}, *FEW)["each group in turn"]
        groups, estimate = formation().groups, fleet_estimate(trains, FEW[1])
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
