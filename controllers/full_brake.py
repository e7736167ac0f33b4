"""No wheel-slide protection."""

from collections.abc import Sequence
from functools import cache

from railgrip.controllers.brake import BrakeGroup
from railgrip.controllers.law import Demand, Law, law
from railgrip.controllers.sampled import Draft, Formula


class FullBrake(Law):
    """Full pressure from the first instant, whatever the wheels do."""

    def __init__(self, groups: Sequence[BrakeGroup]) -> None:
        """Brake every one of `groups` with its highest pressure."""
        super().__init__(full_brake(len(groups)), groups, {})


@cache
def full_brake(groups: int) -> Formula:
    """Return the formula for so many groups."""

    def demand_with(draft: Draft) -> Demand:
        return lambda draft, group: group.brake["pressure_max"]

    return law("FullBrake", "Full brake pressure, no wheel-slide protection", groups, demand_with)
