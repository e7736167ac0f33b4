"""Sensors without errors."""

from collections.abc import Mapping
from typing import Literal

import numpy as np

from railgrip.scenario.onboard import SensorModel
from railgrip.scenario.schema import Scenario
from railgrip.vehicle.signals import Layout


class Ideal(SensorModel):
    """Readings are the plant's outputs."""

    kind: Literal["ideal"]

    def open(self, scenario: Scenario, layout: Layout, wheel_radius: float) -> "IdealSensors":
        """Return the sensors of a stop."""
        return IdealSensors(layout)


class IdealSensors:
    """Readings are the plant's outputs.

    Attributes:
        places: Output that each entry of a reading is taken from.
        fields: Fields of `Instruments` in cycle.h.
    """

    def __init__(self, layout: Layout) -> None:
        places = [layout.output[name] for name in layout.reading]
        self.places = np.concatenate([np.arange(place.start, place.stop) for place in places])
        self.fields: Mapping[str, object] = {"output_at": self.places}

    def draw(self) -> None:
        """Draw no noise."""
