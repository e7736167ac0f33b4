"""A simulated fleet, and its joint estimation: what each stop estimates, and what all stops determine together.

A train's quantities θ deviate from the means μ of their lots, those of one stop x from θ, and a stop estimates

    y = A x + B o + e,   x = θ + δ,   θ = L μ + d,

with deviations d of the trains, scatter δ from stop to stop, transducer offsets o that each train keeps, and the error
e with the covariance of the stop's own estimate. All are Gaussian, so that the posterior of μ, θ and o is exact.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
import xarray

from railgrip.base.arrays import generator
from railgrip.estimation.models import model_of
from railgrip.estimators.belief import Matrix, Vector
from railgrip.recording.samples import period_of, reading_of, truth_of
from railgrip.studies.pad_monitor.evidence import MODEL, evidence_of, formation
from railgrip.studies.pad_monitor.life import (
    COASTING,
    LOAD_DEVIATION,
    LOT_DEVIATION,
    SCALE_DEVIATION,
    Life,
    Release,
    first_health,
    live,
)


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
        distances=tuple(float(truth_of(recording, "v").sum() * period_of(recording)) for recording, _ in stops),
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
    of_trains = [
        StopEstimate(train=i, mean=one.mean, covariance=one.covariance, of_quantities=one.of_quantities,
                     of_offsets=one.of_offsets)
        for i, train in enumerate(trains) for one in train.estimates[:stops]
    ]  # fmt: skip
    return estimate_fleet(of_trains, hierarchy(with_lot=with_lot), len(trains))
