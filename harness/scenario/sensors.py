"""The table [sensors]: the instruments between the plant and the onboard parts."""

from collections.abc import Collection
from typing import Annotated, Any

import numpy as np

from railgrip.base import registry
from railgrip.scenario.kinds import ByKind, Custom, by_kind
from railgrip.scenario.seed import generator
from railgrip.scenario.table import Period, Seed, Table, optional


class SensorModel(Table):
    """Sensors of one kind: their table, which also creates the implementation.

    Each kind is a subclass in a module of `railgrip.simulate.sensors`.
    """

    kind: Any  # each class lists its name as a literal

    @property
    def pulses(self) -> int:
        """Teeth of each pole wheel; 0 for sensors without pole wheels."""
        return 0

    @property
    def pressure_lag(self) -> float:
        """Time constant of the readings of the cylinder pressure [s]."""
        return 0.0

    def sampled_every(self, communication: float) -> int:
        """Return the communication steps [s] between two readings."""
        return 1

    def extra_readings(self, scenario: Any, outputs: Collection[str]) -> tuple[Any, ...]:
        """Return the signals that they read from a plant with `outputs`, in addition to those of all sensors.

        Raises:
            ScenarioError: A named quantity does not exist, or is not an output of the plant.
        """
        return ()

    def open(self, scenario: Any, layout: Any, wheel_radius: float) -> Any:
        """Return the sensors of a stop, with `read(sample, truth)`.

        Errors that are constant over a stop are drawn here.
        """
        raise NotImplementedError


class SampledSensors(SensorModel):
    """Sensors with errors and a sampling period."""

    period: Period | None = optional(
        "at which all are sampled and their noise is drawn, a whole multiple of the communication step, or shorter: "
        "then the loop reads one of several samples; without it that step itself, or of service sensors 1 ms"
    )
    seed: Seed | None = optional(
        "seed of the lot and the noise of the sensors, to repeat a stop on the same rail with other sensors of the "
        "same kind; without it the seed of the scenario"
    )

    def random(self, scenario: Any, purpose: str) -> np.random.Generator:
        """Return the stream of random numbers for one purpose of these sensors."""
        return generator(scenario.seed if self.seed is None else self.seed, f"sensors.{purpose}")

    def sampled_every(self, communication: float) -> int:
        """Return the communication steps [s] between two readings."""
        return max(round((self.period or 0.0) / communication), 1)

    def samples_in(self, communication: float) -> int:
        """Return the number of samples that the instruments take per communication step [s], of which the loop reads
        one.
        """
        return max(round(communication / (self.period or communication)), 1)


def _sensors() -> dict[str, type[Table]]:
    return by_kind(*registry.parts(registry.SENSORS, SensorModel))


class OwnSensors(Custom, SensorModel):
    """Sensors that are a user-defined class, read in every communication step."""


Sensors = Annotated[SensorModel, ByKind(_sensors, "sensors", OwnSensors)]
