"""Rotating eddy-current brakes."""

from typing import Any, Literal

import numpy as np

from railgrip.rolling_stock.brakes import AxleBrake, EddyCurrent


class EddyCurrentAxle(EddyCurrent, AxleBrake):
    """A rotating eddy-current brake on the discs of an axle: RailBraking.Components.EddyCurrentBrake."""

    kind: Literal["eddy_current_axle"]

    def law(self, units: float) -> str:  # pyright: ignore[reportUnusedParameter]
        """Return the parameters of the component's law for a number of brakes, in Modelica."""
        return f"v_peak={self.speed_peak}"

    def force_at(self, speed: Any, units: float = 1.0, load: float = np.inf) -> Any:  # pyright: ignore[reportUnusedParameter]
        """Return the force at a speed [m/s] of a number of brakes on axles with a static load [N]."""
        return self.force_of(units, speed)
