"""Slip-based two-level control (SBC): the state of the art that adhesion-based control is measured against."""

from collections.abc import Sequence
from dataclasses import dataclass

from controllers.brake import BrakeGroup
from controllers.sight import Sight


@dataclass(frozen=True, slots=True, kw_only=True)
class SlipLevels:
    """Slip levels of the two-level controller.

    Attributes:
        low: Slip below which the brake is applied [1].
        high: Slip above which it is released [1].
        speed_min: Train speed below which wheel-slide protection is off and the brake is applied [m/s].
        hold: True for the vent/hold/fill form: between the levels the pressure stays as it is. False for the
            two-state form: between the levels the last action goes on.
    """

    low: float
    high: float
    speed_min: float
    hold: bool

    def __post_init__(self) -> None:
        """Refuse levels that cannot switch.

        Raises:
            ValueError: Not 0 < low < high < 1, or a negative speed.
        """
        if not 0.0 < self.low < self.high < 1.0:
            raise ValueError(
                f"SlipBased: levels are slips with 0 < low < high < 1, got low = {self.low}, high = {self.high}; "
                "for a locked wheel use full_brake."
            )
        if self.speed_min < 0.0:
            raise ValueError(f"SlipBased: speed_min must not be negative, got {self.speed_min} m/s.")


class SlipBased:
    """Apply below the low level, release above the high one.

    Source: Schwarz, Posielek, Goetjes (2021), §4: s_low = 10 %, s_high = 15 %.
    """

    def __init__(self, groups: Sequence[BrakeGroup], levels: SlipLevels) -> None:
        """Control `groups` between `levels`."""
        self._levels = levels
        self._full = tuple(group.pressure_max for group in groups)
        self._demands = list(self._full)

    def decide(self, sight: Sight) -> tuple[float, ...]:
        """Return the demanded pressure of each group [Pa]."""
        levels = self._levels
        if sight.speed < levels.speed_min:
            return self._full
        for g, slip in enumerate(sight.slip):
            if slip > levels.high:
                self._demands[g] = 0.0
            elif slip < levels.low:
                self._demands[g] = self._full[g]
            elif levels.hold:
                self._demands[g] = sight.pressure[g]
        return tuple(self._demands)
