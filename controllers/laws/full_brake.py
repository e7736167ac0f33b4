"""No wheel-slide protection."""

from collections.abc import Mapping
from typing import ClassVar

from railgrip.controllers.law import FULL_PRESSURE, Demand, GroupLaw, TypeTestEntry
from railgrip.controllers.sampled import Expression, FormulaBuilder


class FullBrake(GroupLaw):
    """Full pressure from the first instant, whatever the wheels do."""

    description = "Full brake pressure, no wheel-slide protection"
    brake_data = FULL_PRESSURE
    entries: ClassVar[Mapping[str, TypeTestEntry]] = {
        "full_brake": TypeTestEntry(description="no wheel-slide protection", role="baseline", slip="read")
    }

    @staticmethod
    def demand_with(draft: FormulaBuilder, tuning: Mapping[str, Expression]) -> Demand:
        """Return full pressure."""
        return lambda draft, group: group.brake["pressure_max"]
