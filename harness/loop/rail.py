"""What the track does to the train, in tables."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


class Profile(Protocol):
    """Friction on an even grid over time or distance, as `railgrip.scenario.adhesion.Profile`."""

    @property
    def over_time(self) -> bool:
        """Whether the grid runs over time [s], else over distance [m]."""
        ...

    @property
    def step(self) -> float:
        """Of the grid."""
        ...

    @property
    def mu0_at(self) -> NDArray[np.float64]:
        """Friction at its points, shape (n, wheelsets)."""
        ...

    def mu0(self, time: float, distance: float) -> Vector:
        """Return the friction at each wheelset."""
        ...


class Sections(Protocol):
    """A force that is constant or straight between places, as `railgrip.scenario.track.TrackForce`."""

    @property
    def begins(self) -> tuple[float, ...]:
        """Where each section begins, the first at −∞ [m]."""
        ...

    @property
    def forces(self) -> tuple[float, ...]:
        """On the train where each section begins, forward positive [N]."""
        ...

    @property
    def rates(self) -> tuple[float, ...]:
        """Change of the force over each section, 0 for the first [N/m]."""
        ...

    def at(self, distance: float) -> float:
        """Return the force at a distance."""
        ...


@dataclass(frozen=True, slots=True)
class TabulatedRail:
    """Friction and force along the track."""

    friction: Profile
    sections: Sections

    def mu0(self, time: float, distance: float, /) -> Vector:
        """Return the maximum friction at each wheelset."""
        return self.friction.mu0(time, distance)

    def force(self, distance: float, /) -> float:
        """Return the force of gradient and curve on the train, forward positive [N]."""
        return self.sections.at(distance)
