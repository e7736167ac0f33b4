"""Simulated stops of a fleet, joint estimates of its pads and wheel radii, and releases designed for information.

Releases of single groups are made by hand, as a small modulation, and designed for information on the pads (D-optimal).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import xarray

from railgrip.base.arrays import Matrix, Vector, generator
from railgrip.campaign.work import work
from railgrip.estimation.fleet import FleetEstimate, Hierarchy, StopEstimate, estimate_fleet
from railgrip.estimation.judgement import error_figures
from railgrip.estimation.models import model_of
from railgrip.recording.samples import period_of, reading_of, truth_of
from railgrip.report.baseline import Finding, mean
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


def train_stops(case: tuple[int, int, Releases]) -> TrainStops:
    """Simulate the stops of a train of the fleet, and estimate from each.

    Args:
        case: Seed of its life, number of stops, and releases in every stop.
    """
    seed, count, releases = case
    radii = RADIUS_DEVIATION * generator(seed, "fleet.radii").standard_normal(formation().groups)
    # The wear of a life of 200 stops; only the first stops are simulated.
    life = Life(stops=200, seed=seed, releases=releases, radii=tuple((1.0 + radii).tolist()))
    stops = list(live(life, range(count)))
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


FEW = (2, 3)
"""Trains and stops of the quick form and of the headline numbers."""
FIRST_SEED = 301
"""Seed of the first train; no number of the model was chosen on trains with these seeds."""
COUNTS = (1, 5, 10, 20, 40)
"""Stops of each train after which the estimates are compared."""
TARGET = 0.05
"""Standard deviation to which pads of single groups should be known."""

DESIGNS: Mapping[str, Callable[[], Releases]] = {
    "none": lambda: (),
    "0.2 bar for 1 s": lambda: MODULATION,
    "each group in turn": lambda: IN_TURN,
    "D-optimal": cache(lambda: design(CANDIDATES, len(IN_TURN))),
}
"""Kinds of releases; as many are designed as are made by hand."""


@cache
def simulate(releases: str, trains: int, stops: int) -> Sequence[TrainStops]:
    """Return the stops of trains with a kind of releases, a key of `DESIGNS`; all kinds have the same trains."""
    of_train = DESIGNS[releases]()
    seeds = range(FIRST_SEED, FIRST_SEED + trains)
    with work(Path(__file__)) as job:
        return job.map(train_stops, [(seed, stops, of_train) for seed in seeds])


def deviation_alone(trains: Sequence[TrainStops], stops: int) -> Vector:
    """Return the mean claimed deviation of the pads of each group from the readings of each train alone."""
    alone = [fleet_estimate([train], stops, with_lot=False) for train in trains]
    return np.mean([estimate.train_deviation[0, : formation().groups] for estimate in alone], axis=0)


def extra_metres(releases: str, trains: int, stops: int) -> float:
    """Return the mean distance of a stop minus that of the same stop without releases [m]."""
    with_them, without = (
        np.array([train.distances for train in simulate(kind, trains, stops)]) for kind in (releases, "none")
    )
    return float(np.mean(with_them - without))


def _figures(trains: Sequence[TrainStops], stops: int, quantity: str) -> dict[str, float]:
    """Return RMSE, mean claimed deviation and coverage of a quantity of each train and group, "pads" or "radii"."""
    estimate, groups = fleet_estimate(trains, stops), formation().groups
    part = slice(groups) if quantity == "pads" else slice(-groups, None)
    deviation = estimate.train_deviation[:, part]
    figures = error_figures(
        estimate.trains[:, part] - np.array([getattr(train, quantity) for train in trains]), deviation
    )
    return {"RMSE": figures["RMSE"], "claimed": float(deviation.mean()), "coverage of 95 %": figures["coverage"]}


def pad_rows(releases: str, trains: int, stops: int) -> list[dict[str, Any]]:
    """Return errors and claimed deviations of the pads by number of stops of each train."""
    found, longer = simulate(releases, trains, stops), extra_metres(releases, trains, stops)
    return [
        {"stops of each train": count, "longer stop": longer}
        | _figures(found, count, "pads")
        | {f"group {g + 1} without lot": alone for g, alone in enumerate(deviation_alone(found, count))}
        for count in COUNTS
        if count <= stops
    ]


def radius_rows(trains: int, stops: int) -> list[dict[str, Any]]:
    """Return errors and claimed deviations of the wheel radii by number of stops, from stops without releases."""
    found = simulate("none", trains, stops)
    return [{"stops of each train": count} | _figures(found, count, "radii") for count in COUNTS if count <= stops]


def needed_row(releases: str, trains: int, stops: int) -> dict[str, Any]:
    """Return, by group, the number of stops after which its pads are known to `TARGET` on average, or None."""
    found = simulate(releases, trains, stops)
    known = np.array([deviation_alone(found, count) <= TARGET for count in range(1, stops + 1)])
    needed = [int(np.argmax(of_group)) + 1 if of_group[-1] else None for of_group in known.T]
    return {"longer stop": extra_metres(releases, trains, stops)} | {f"group {g + 1}": n for g, n in enumerate(needed)}


def design_row(releases: str) -> dict[str, Any]:
    """Return the information that one stop has on the pads, expected before the stop, and their deviations by it."""
    of_train, groups = DESIGNS[releases](), formation().groups
    deviation = np.sqrt(np.diag(np.linalg.inv(expected_information(of_train))))
    ratio = np.exp((log_determinant(IN_TURN) - log_determinant(of_train)) / groups)
    return (
        {"log det of the information": log_determinant(of_train)}
        | {f"group {g + 1}": float(of_group) for g, of_group in enumerate(deviation)}
        | {"variance over that by hand": float(ratio)}
    )


def headlines() -> list[Finding]:
    """Return errors and deviations of the joint estimate from a few stops, and the information of a stop."""
    found = simulate("each group in turn", *FEW)
    pads, radii = (_figures(found, FEW[1], quantity) for quantity in ("pads", "radii"))
    return [
        mean("fleet: pad friction RMSE", pads["RMSE"]),
        mean("fleet: claimed deviation of pad friction", pads["claimed"]),
        mean("fleet: wheel radius RMSE", radii["RMSE"]),
        # 2 % of the geometric mean of the variances of four groups.
        Finding("fleet: log det of the information of a stop", log_determinant(IN_TURN), "1", 0.08),
    ]
