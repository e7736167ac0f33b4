"""The scatter of a train's stopping distance: stops by time steps whose brakes are drawn from their dispersion."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import get_args

import numpy as np

from railgrip.base.arrays import Matrix, Vector, generator
from railgrip.rolling_stock.dispersion import Dispersion, Quantity
from railgrip.rolling_stock.schema import Train
from railgrip.rolling_stock.stopping import scattered_distances


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scatter:
    """Distances of drawn stops from a speed.

    Attributes:
        speed: Speed at the brake demand [m/s].
        distances: Stopping distance of each draw, shape (draws,) [m].
    """

    speed: float
    distances: Vector

    @property
    def figures(self) -> dict[str, float]:
        """Mean, standard deviation and quantiles of the distance [m]."""
        quantiles = {
            f"P{100 * level:g}": float(np.quantile(self.distances, level)) for level in (0.05, 0.5, 0.95, 0.99)
        }
        spread = {"mean": float(self.distances.mean()), "standard deviation": float(self.distances.std(ddof=1))}
        return {**spread, **quantiles, "longest": float(self.distances.max())}


def scatter(train: Train, speed: float, dispersion: Sequence[Dispersion], *, draws: int, seed: int) -> Scatter:
    """Return stops of a train whose brakes are drawn; the same arguments give the same distances.

    Args:
        train: The train.
        speed: Speed at the brake demand [m/s].
        dispersion: What deviates, and by how much.
        draws: Number of stops, at least 2.
        seed: Seed of the draws.

    Raises:
        InputError: The train has dynamic brakes at its axles, or a draw does not stop within ten minutes.
    """
    deviations = _deviations(train, dispersion, draws, seed)
    return Scatter(speed=speed, distances=scattered_distances(train, speed, deviations))


def _deviations(train: Train, dispersion: Sequence[Dispersion], draws: int, seed: int) -> dict[str, Matrix]:
    """Return the deviations of each quantity, shape (draws, axles); that of an axle is the mean of its brake units."""
    units = np.repeat(np.arange(len(train.axles)), [round(axle.units) for axle in train.axles])
    valves = np.array([train.valve_of_group[axle.group] for axle in train.axles])
    # Column per axle: its part in what has a draw of its own.
    shares = {
        "train": np.ones((1, len(valves))),
        "group": (np.arange(len(train.groups_per_valve))[:, None] == valves).astype(float),
        "unit": (units[:, None] == np.arange(len(valves))) / np.maximum(np.bincount(units, minlength=len(valves)), 1),
    }
    deviations: dict[str, Matrix] = {
        name: np.full((draws, len(valves)), 0.0 if name == "pressure" else 1.0) for name in get_args(Quantity)
    }
    random = generator(seed, "scatter of a train")
    for one in dispersion:
        share = shares[one.per]
        deviation = one.of(random.standard_normal((draws, len(share)))) @ share
        if one.quantity == "pressure":
            deviations[one.quantity] += deviation
        else:
            deviations[one.quantity] *= 1.0 + deviation
    return deviations
