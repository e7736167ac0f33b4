"""Checks of the values that a user's parts return while a stop runs: limits, and likely mistakes of units and signs."""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from railgrip.base.arrays import Array
from railgrip.base.errors import ControllerFailed
from railgrip.base.units import mistake
from railgrip.controllers.observation import Observation
from railgrip.vehicle.formation import Formation

PATIENCE = 1.0  # s; until a mistake of units is named: filters have settled, and cylinders begin to fill
_MIN_SHARE = 0.01
"""Share of full pressure.

Pads do not touch below about 5 %, so a law whose demands never exceed 1 % does not brake; bar, kPa, mbar and shares of
full brake, mistaken for Pa, are 1 % or less.
"""
_ROUNDING = 1e-9
"""Share of full pressure by which rounding may take a demand out of range."""
SMALLEST_RECOGNISED = {"speed": 1.0, "wheelset_speed": 2.0, "acceleration": 0.3, "cylinder_pressure": 2e4}
"""Magnitudes in SI units above which the unit of a signal can be recognised, given offsets of some percent of full
scale."""
_MAX_RATIO = 1.5
"""Above any adhesion, pad friction or slip: a larger estimate is in percent."""
_SLIDES = 0.1  # slip; readings of the speed of a rolling train are less than 10 % off
_ROUGHLY_ZERO = 0.02  # adhesion and friction; filters overshoot zero by less
_BRAKES = 0.2
"""Share of full pressure from which on a train slows on any gradient; below, an honest estimate may be negative."""
_SLOWED = 5.0  # m/s; a train that slows by this without a change of slip is not on a rail
_SIGNS = {
    "slip": "; the wheels read slower than the train: slip is 1 - r w/v, positive in braking",
    "adhesion": "; adhesion is positive in braking",
    "pad_friction": "; friction of pads is positive",
}
"""Name of an estimate → the end of the message on its sign."""


def not_demands(place: str, found: str, groups: int, time: float) -> ControllerFailed:
    """Return the error of a controller that returned something else than demands."""
    shape = f"{groups} groups, shape ({groups},)"
    return ControllerFailed(f"{place} returned {found}, not the demanded pressures [Pa] of {shape}.{at_time(time)}")


class DemandLimits:
    """Limits the demands of other than built-in laws to what cylinders take, and counts the decisions it changed.

    Attributes:
        maximum: Maximum pressure of each group [Pa]; once `is_pascal` is set, the loop calls `limit` only beyond 0 to
            this.
        is_pascal: Whether the demands have been large enough to be in Pa.
        limited: Number of decisions that were limited.
    """

    def __init__(self, formation: Formation, place: str = "The controller") -> None:
        """Start without limited decisions; `place` names the source of the demands in messages."""
        self.maximum, self.is_pascal, self.limited = formation.pressure_max, False, 0
        self._place, self._lowest, self._highest = place, 0.0, 0.0
        self._share, self._since = 0.0, math.inf

    def limit(self, demands: Array, observation: Observation) -> Array:
        """Return demands limited to 0 and the maximum pressure of each cylinder [Pa]; count decisions that were
        outside.

        Raises:
            ControllerFailed: The demands are not finite, or all of them are too small to be in Pa.
        """
        self.require_finite(demands, observation)
        within = np.clip(demands, 0.0, self.maximum)
        if (np.abs(demands - within) > _ROUNDING * self.maximum).any():
            self.limited += 1
            self._lowest, self._highest = min(self._lowest, demands.min()), max(self._highest, demands.max())
        if not self.is_pascal:
            self._refuse_another_unit(within, observation)
        return within

    def require_finite(self, demands: Array, observation: Observation) -> None:
        """Raise an error for demands that are infinite or NaN.

        Raises:
            ControllerFailed: A demand is not finite.
        """
        if not np.isfinite(demands).all():
            raise not_demands(self._place, str(demands.tolist()), demands.size, observation.time)

    def sentence(self, decisions: int) -> str:
        """Return a sentence on the decisions that were limited, out of all `decisions`; empty if there were none."""
        if not self.limited:
            return ""
        return (
            f" In {self.limited} of {decisions} decisions the controller demanded pressures beyond what cylinders "
            f"take, between {self._lowest:.6g} and {self._highest:.6g} Pa; they were limited to 0 and "
            f"{self.maximum.max():.6g} Pa."
        )

    def _refuse_another_unit(self, demands: Array, observation: Observation) -> None:
        """Raise an error if, for a second after the first demand, no demand brakes although the driver requires it."""
        full = float(self.maximum.max())
        self._share = max(self._share, float((demands / self.maximum).max()))
        self.is_pascal = self._share > _MIN_SHARE
        if self.is_pascal or self._share == 0.0 or float(observation.driver_demand.max()) <= _MIN_SHARE * full:
            return
        self._since = min(self._since, observation.time)
        if observation.time >= self._since + PATIENCE:
            words = mistake(self._share) or "another unit than Pa, such as bar or a share of full brake"
            raise ControllerFailed(
                f"The controller demands {self._share * full:.3g} Pa at most, and a full brake has {full:.6g} Pa; it "
                f"looks like {words}. At {observation.time:.3f} s."
            )


class UnitCheck:
    """Compares the first second of a signal with expected values, and names the likely mistake of units."""

    def __init__(self, least: float) -> None:
        """Compare only where the expected magnitude reaches `least`; below it, offsets and noise dominate the ratio."""
        self._least, self._since, self._ratios, self._done = least, math.inf, list[Array](), False

    def mistake(self, time: float, value: Any, expected: Any) -> str:
        """Return the likely mistake, once a second of the stop has passed; else ''."""
        value, expected = np.atleast_1d(value), np.atleast_1d(expected)
        if self._done or not np.isfinite(value).all() or not (np.abs(expected) >= self._least).all():
            return ""
        self._ratios.append(value / expected)
        self._since = min(self._since, time)
        if time < self._since + PATIENCE:
            return ""
        self._done = True
        # The median: a sensor that fails now and then, or a wheel that locks, must not look like a wrong unit.
        medians: list[float] = np.median(self._ratios, axis=0).tolist()
        return next((f"; it looks like {words}" for ratio in medians if (words := mistake(ratio))), "")

    def mistake_of_ratio(self, time: float, value: Any) -> str:
        """Return a clause if a ratio is in percent, once a second of the stop has passed; else ''."""
        values = np.atleast_1d(value)
        return self.mistake(time, np.where(np.abs(values) > _MAX_RATIO, 100.0, 1.0), np.ones(values.shape))


class SignCheck:
    """Compares the signs of estimates with those that braking gives them, and looks for estimates that never change."""

    def __init__(self, name: str, formation: Formation) -> None:
        """Check the estimate of a name on the groups of a formation."""
        self._name, self._radius, self._pressure_max = name, formation.wheel_radius, formation.pressure_max
        self._wrong_since, self._first, self._speed = np.array(math.inf), np.empty(0), math.nan

    def mistake(self, observation: Observation, value: ArrayLike) -> str:
        """Return the mistake, in words that follow the value; '' for a value that may be right."""
        values, time = np.atleast_1d(np.asarray(value, dtype=np.float64)), observation.time
        is_wrong = self._is_wrong(observation, values)
        self._wrong_since = np.where(is_wrong, np.minimum(self._wrong_since, time), math.inf)
        if np.any(time >= self._wrong_since + PATIENCE):  # without a break in a group
            return _SIGNS[self._name]
        # Adhesion and friction of pads may be assumptions, or steady in a steady braking.
        return self._stuck(observation, values) if self._name in ("speed", "wheelset_speed", "slip") else ""

    def _is_wrong(self, observation: Observation, values: Array) -> NDArray[np.bool_]:
        """Return for each group whether its value has the sign that braking does not give it."""
        match self._name:
            case "slip":
                rolling = max(observation.speed, _SLOWED) / self._radius
                read = 1.0 - observation.wheelset_speed / rolling
                return (read > _SLIDES) & (values < -0.5 * read)
            case "adhesion":
                # A group without a reading of its pressure counts as braked.
                is_braked = ~(observation.pressure < _BRAKES * self._pressure_max)
                return (observation.driver_demand > 0.0) & is_braked & (values < -_ROUGHLY_ZERO)
            case "pad_friction":
                return values < -_ROUGHLY_ZERO
            case _:
                return np.zeros(values.shape, dtype=bool)

    def _stuck(self, observation: Observation, values: Array) -> str:
        if not self._first.size:
            self._first, self._speed = values.copy(), observation.speed
        has_moved = not np.array_equal(values, self._first)
        if has_moved:
            self._speed = math.nan  # compared with nothing from now on
        slowed = self._speed - observation.speed
        return f"; it has not changed since the start, while the train slowed by {slowed:.3g} m/s" * (slowed > _SLOWED)


def at_time(time: float | None) -> str:
    """Return a sentence that states the time [s]; empty if it is unknown."""
    return "" if time is None else f" At {time:.3f} s."
