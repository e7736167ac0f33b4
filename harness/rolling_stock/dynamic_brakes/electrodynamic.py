"""Traction motors as generators."""

from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from railgrip.rolling_stock.brakes import AxleBrake
from railgrip.scenario.quantity import UnitRange


class Electrodynamic(AxleBrake):
    """Traction motors as generators: RailBraking.Components.ElectrodynamicBrake."""

    component: ClassVar[str] = "ElectrodynamicBrake"
    kind: Literal["electrodynamic"]
    power: Annotated[
        float,
        UnitRange("W", between=(1e3, 1e7), usual=(3e4, 2e6), because="axles brake with 50 kW to 1.6 MW"),
    ] = Field(description="maximum power at the rim of an axle: above power/force the force is power/speed")
    adhesion_limit: Annotated[float, UnitRange("1", between=(0.02, 0.5))] | None = Field(
        default=None, description="adhesion on the static load of its axles to which the force is limited"
    )

    @property
    def speed_of_force(self) -> float:
        """Speed above which the power limits the force [m/s]."""
        return self.power / self.force

    def law(self, units: float) -> str:
        """Return the parameters of the component's law for a number of brakes, in Modelica."""
        return f"P_max={units * self.power:.10g}"

    def largest(self, units: float = 1.0, load: float = np.inf) -> float:
        """Return the maximum force of a number of brakes on axles with a static load [N]."""
        return min(units * self.force, np.inf if self.adhesion_limit is None else self.adhesion_limit * load)

    def force_at(self, speed: Any, units: float = 1.0, load: float = np.inf) -> Any:
        """Return the force at a speed [m/s] of a number of brakes on axles with a static load [N]."""
        by_power = units * self.power / np.maximum(speed, 1e-3)
        return np.minimum(self.largest(units, load), by_power) * self.fade(speed)
