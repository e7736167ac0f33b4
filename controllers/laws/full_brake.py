"""No wheel-slide protection."""

from railgrip.controllers.law import FULL_PRESSURE, GroupLaw, GroupObservation
from railgrip.controllers.sampled import Expression, FormulaBuilder, Symbols


class FullBrake(GroupLaw):
    """Full pressure from the first instant, whatever the wheels do."""

    description = "Full brake pressure, no wheel-slide protection"
    brake_data = FULL_PRESSURE

    @classmethod
    def demand(cls, draft: FormulaBuilder, tuning: Symbols, group: GroupObservation) -> Expression:
        """Return the demanded pressure of one group [Pa]."""
        return group.brake["pressure_max"]
