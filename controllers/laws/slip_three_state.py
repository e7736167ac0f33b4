"""Slip-based two-level control with valves that vent, hold and fill."""

from dataclasses import dataclass
from typing import Annotated

from railgrip.controllers.laws.slip_two_state import SlipLevels, SlipTwoState


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldingLevels(SlipLevels):
    """Slip levels; the pressure is held between them."""

    hold: Annotated[float, "1", "1: between the levels the pressure stays; 0: the last action goes on", 1.0] = 1.0


class SlipThreeState(SlipTwoState):
    """Fill below the low level, vent above the high one and hold in between."""

    tuning = HoldingLevels
