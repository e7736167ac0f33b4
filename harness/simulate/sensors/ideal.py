"""Sensors without errors."""

from typing import Literal

from railgrip.scenario.schema import Scenario
from railgrip.scenario.sensors import SensorModel
from railgrip.simulate.loop.sensors import IdealSensors
from railgrip.vehicle.signals import Layout


class Ideal(SensorModel):
    """Readings are the plant's outputs."""

    kind: Literal["ideal"]

    def open(self, scenario: Scenario, layout: Layout, wheel_radius: float) -> IdealSensors:
        """Return the sensors of a stop."""
        return IdealSensors(layout)
