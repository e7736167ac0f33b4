"""No wheel-slide protection."""

from collections.abc import Mapping
from typing import ClassVar

from railgrip.controllers.law import FULL_PRESSURE, Demand, Entry, GroupLaw
from railgrip.controllers.sampled import Draft, Expression


class FullBrake(GroupLaw):
    """Full pressure from the first instant, whatever the wheels do."""

    description = "Full brake pressure, no wheel-slide protection"
    brake_data = FULL_PRESSURE
    entries: ClassVar[Mapping[str, Entry]] = {
        "full_brake": Entry(description="no wheel-slide protection", role="baseline", slip="read")
    }

    @staticmethod
    def demand_with(draft: Draft, tuning: Mapping[str, Expression]) -> Demand:
        """Return full pressure."""
        return lambda draft, group: group.brake["pressure_max"]
