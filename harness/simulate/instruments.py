"""The sensors of a scenario."""

from collections.abc import Collection

from railgrip.base.errors import ScenarioError
from railgrip.scenario.schema import Scenario
from railgrip.scenario.sensors import SensorModel
from railgrip.simulate.loop.parts import Instruments
from railgrip.vehicle.signals import READINGS, Layout, Signal


def readings_of(scenario: Scenario, outputs: Collection[str]) -> tuple[Signal, ...]:
    """Return what the sensors of a scenario show of a plant with these outputs.

    Raises:
        ScenarioError: A quantity is named that is none, or that the plant does not show.
    """
    sensors = scenario.sensors
    return (*READINGS, *(sensors.extra_readings(scenario, outputs) if isinstance(sensors, SensorModel) else ()))


def sensors_of(scenario: Scenario, layout: Layout, wheel_radius: float) -> Instruments:
    """Return the sensors of a scenario; what is constant over a stop is drawn here.

    Raises:
        ScenarioError: They are a class of the user's own, or do not suit the vehicle.
    """
    if not isinstance(scenario.sensors, SensorModel):
        raise ScenarioError(
            f"{scenario.name}: [sensors] kind '{scenario.sensors.kind}' is no sensor model of this project"
        )
    return scenario.sensors.opened(scenario, layout, wheel_radius)
