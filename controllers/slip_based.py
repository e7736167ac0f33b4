"""Slip-based two-level control (SBC): the state of the art that adhesion-based control is measured against."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cache

from railgrip.controllers.brake import BrakeGroup
from railgrip.controllers.law import Demand, GroupObservation, Law, law
from railgrip.controllers.sampled import Draft, Expression, Formula, choose


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


class SlipBased(Law):
    """Apply below the low level, release above the high one.

    Source: Schwarz, Posielek, Goetjes (2021), §4: s_low = 10 %, s_high = 15 %. As long as no speed has been read (NaN)
    there is no slip to protect from, and the brake is applied.
    """

    def __init__(self, groups: Sequence[BrakeGroup], levels: SlipLevels) -> None:
        """Control `groups` between `levels`."""
        super().__init__(slip_based(len(groups)), groups, asdict(levels))


@cache
def slip_based(groups: int) -> Formula:
    """Return the formula for so many groups."""

    def demand_with(draft: Draft) -> Demand:
        low = draft.parameter("low", "1", "slip below which the brake is applied", maximum=1.0)
        high = draft.parameter("high", "1", "slip above which it is released", maximum=1.0)
        speed_min = draft.parameter("speed_min", "m/s", "train speed below which protection is off")
        hold = draft.parameter(
            "hold", "1", "1: between the levels the pressure stays; 0: the last action goes on", maximum=1.0
        )

        def demand(draft: Draft, group: GroupObservation) -> Expression:
            applied = draft.state(
                group.label("applied"), "1", "1 when the brake was applied, 0 when released", start=1.0
            )
            full, protecting = group.brake["pressure_max"], group.speed >= speed_min
            releasing, applying = group.slip > high, group.slip < low
            draft.keep(applied, choose(protecting, choose(releasing, 0.0, choose(applying, 1.0, applied)), applied))
            between = choose(hold, group.pressure, applied * full)
            return choose(protecting, choose(releasing, 0.0, choose(applying, full, between)), full)

        return demand

    return law("SlipBased", "Slip-based two-level wheel-slide protection", groups, demand_with)
