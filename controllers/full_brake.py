"""No wheel-slide protection."""

from collections.abc import Sequence

from controllers.brake import BrakeGroup
from controllers.sight import Sight


class FullBrake:
    """Full pressure from the first instant, whatever the wheels do."""

    def __init__(self, groups: Sequence[BrakeGroup]) -> None:
        """Brake every one of `groups` with its highest pressure."""
        self._demands = tuple(group.pressure_max for group in groups)

    def decide(self, sight: Sight) -> tuple[float, ...]:
        """Return the highest pressure of each group [Pa]."""
        return self._demands
