"""No wheel-slide protection."""

from collections.abc import Mapping

from railgrip.controllers.law import FULL_PRESSURE, Demand, GroupLaw
from railgrip.controllers.sampled import Expression, FormulaBuilder


class FullBrake(GroupLaw):
    """Full pressure from the first instant, whatever the wheels do."""

    description = "Full brake pressure, no wheel-slide protection"
    brake_data = FULL_PRESSURE

    @staticmethod
    def demand_with(draft: FormulaBuilder, tuning: Mapping[str, Expression]) -> Demand:
        """Return a function for full pressure."""
        return lambda draft, group: group.brake["pressure_max"]
