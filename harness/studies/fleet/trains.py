"""A simulated fleet: its stops, what each of them estimates, and the prior of the joint estimation."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
import xarray

from railgrip.base.arrays import generator
from railgrip.estimation.run import model_of
from railgrip.estimators.belief import Matrix, Vector
from railgrip.recording.samples import period_of, reading_of, truth_of
from railgrip.studies.fleet.joint import FleetEstimate, Hierarchy, StopEstimate, estimate_fleet
from railgrip.studies.fleet.releases import Releases
from railgrip.studies.pad_monitor.evidence import MODEL, evidence_of, formation
from railgrip.studies.pad_monitor.life import (
    COASTING,
    LOAD_DEVIATION,
    LOT_DEVIATION,
    SCALE_DEVIATION,
    Life,
    first_health,
    live,
)

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
