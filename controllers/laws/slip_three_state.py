"""Slip-based two-level control with valves that vent, hold and fill."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

from railgrip.controllers.law import TypeTestEntry
from railgrip.controllers.laws.slip_two_state import SlipLevels, SlipTwoState


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldingLevels(SlipLevels):
    """Slip levels; the pressure is held between them."""

    hold: Annotated[float, "1", "1: between the levels the pressure stays; 0: the last action goes on", 1.0] = 1.0


class SlipThreeState(SlipTwoState):
    """Fill below the low level, vent above the high one and hold in between."""

    tuning = HoldingLevels
    entries: ClassVar[Mapping[str, TypeTestEntry]] = {
        "slip_three_state": TypeTestEntry(
            description="three-state slip control, 10 and 15 %", role="baseline", slip="read", tuning="paper"
        ),
        "slip_three_state_searched": TypeTestEntry(
            description="three-state slip control, searched levels, slip as read",
            role="baseline",
            slip="read",
            tuning="type_test",
        ),
        "slip_three_state_estimated": TypeTestEntry(
            description="three-state slip control, searched levels, estimated slip",
            role="baseline",
            slip="estimated",
            tuning="type_test",
        ),
    }
