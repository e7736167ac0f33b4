"""Slip-based two-level control (SBC): the reference that the paper compares adhesion-based control with."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Final, get_args

from railgrip.controllers.law import FULL_PRESSURE, GroupLaw, GroupObservation, Ranges, Tuning
from railgrip.controllers.parameters import SlipSource
from railgrip.controllers.sampled import Expression, FormulaBuilder, Symbols, choose

_RANGES: Final = {"low": (8e-3, 0.3), "high_over_low": (1.1, 10.0)}
"""From below nearly all published peaks to beyond them; sensors do not resolve bands narrower than 10 % of a level."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SlipLevels(Tuning):
    """Slip levels of the two-level controller."""

    low: Annotated[float, "1", "slip below which the brake is applied", 1.0]
    high: Annotated[float, "1", "slip above which it is released", 1.0]
    speed_min: Annotated[float, "m/s", "train speed below which protection is off"] = 0.5
    hold: Annotated[float, "1", "1: between the levels the pressure stays; 0: the last action goes on", 1.0] = 0.0

    POSITIVE: ClassVar[frozenset[str]] = frozenset()
    FIXED: ClassVar[frozenset[str]] = frozenset({"hold"})
    ORDER: ClassVar[tuple[str, ...]] = ("0 < low < high < 1; for a locked wheel use full_brake",)


class SlipTwoState(GroupLaw):
    """Apply below the low level, release above the high one; between the levels the last action continues.

    Source: Schwarz, Posielek, Goetjes (2021), §4: s_low = 10 %, s_high = 15 %. Before the first reading of the speed
    (NaN) the slip is unknown, and the brake is applied.
    """

    description = "Slip-based two-level wheel-slide protection"
    brake_data = FULL_PRESSURE
    tuning = SlipLevels
    ranges: ClassVar[Ranges] = {
        (actuation, slip): _RANGES for actuation in ("ideal", "pneumatic") for slip in get_args(SlipSource)
    }

    @classmethod
    def demand(cls, draft: FormulaBuilder, tuning: Symbols, group: GroupObservation) -> Expression:
        """Return the demanded pressure of one group [Pa]."""
        low, high, speed_min, hold = (tuning[name] for name in ("low", "high", "speed_min", "hold"))
        applied = draft.state(group.label("applied"), "1", "1 when the brake was applied, 0 when released", start=1.0)
        full, protecting = group.brake["pressure_max"], group.speed >= speed_min
        releasing, applying = group.slip > high, group.slip < low
        draft.keep(applied, choose(protecting, choose(releasing, 0.0, choose(applying, 1.0, applied)), applied))
        between = choose(hold, group.pressure, applied * full)
        return choose(protecting, choose(releasing, 0.0, choose(applying, full, between)), full)
