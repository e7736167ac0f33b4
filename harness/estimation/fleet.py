"""Joint estimate of the quantities of a fleet, from Gaussian estimates of many stops of many trains.

A train's quantities θ deviate from the means μ of their lots, those of one stop x from θ, and a stop estimates

    y = A x + B o + e,   x = θ + δ,   θ = L μ + d,

with deviations d of the trains, scatter δ from stop to stop, transducer offsets o that each train keeps, and the error
e with the covariance of the stop's own estimate. All are Gaussian, so that the posterior of μ, θ and o is exact.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from railgrip.base.arrays import Matrix, Vector


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
