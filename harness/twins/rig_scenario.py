"""What decides a run on the roller rig, as a TOML file; two stand in `library`, after Schwarz and Keck (2020), §4."""

from pathlib import Path
from typing import Annotated, Self

from pydantic import Field, model_validator

from railgrip.scenario.quantity import Unit
from railgrip.scenario.table import Delay, Duration, Friction, Name, Parameters, Seed, Speed, Table
from railgrip.scenario.valves import ValveStep
from railgrip.twins.load import Pressure, Time, in_order, load_twin

Slip = Annotated[float, Unit("1", above=0, below=1)]


class Protection(Table):
    """[protection]: the rig's own wheel-slide protection, `railgrip.controllers.slip_based`."""

    low: Slip
    high: Slip
    speed_min: Annotated[float, Unit("m/s", at_least=0)]
    period: Duration


class Surface(Table):
    """[surface]: what lies between wheel and roller; `mu0` runs over time, straight between its points."""

    k_A: Annotated[float, Unit("1", above=0, at_most=1)]  # noqa: N815 - Polach's name, as in the plant
    k_S: Annotated[float, Unit("1", above=0, at_most=1)]  # noqa: N815
    A_falling: Annotated[float, Unit("1", at_least=0, at_most=1)]
    B_falling: Annotated[float, Unit("s/m", at_least=0)]
    mu0: list[tuple[Time, Friction]]
    scatter: Annotated[float, Unit("1", at_least=0, below=1)]
    scatter_time: Duration


class RigSensors(Table):
    """[sensors]: standard deviation of each reading; white from sample to sample."""

    wheelset_speed: Annotated[float, Unit("rad/s", at_least=0)]
    speed: Annotated[float, Unit("m/s", at_least=0)]
    pad_force: Annotated[float, Unit("N", at_least=0)]
    contact_force: Annotated[float, Unit("N", at_least=0)]
    wheelset_load: Annotated[float, Unit("N", at_least=0)]


class RigScenario(Table):
    """Everything that decides a run on the rig but the seed of its sensors, which has a default here."""

    name: Name
    description: str = ""
    seed: Seed
    speed_start: Speed
    stop_speed: Speed
    horizon: Duration
    period: ValveStep
    demand: list[tuple[Time, Pressure]]
    protection: Protection
    surface: Surface
    sensors: RigSensors
    parameters: Parameters = Field(default_factory=dict)
    settled: Delay

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        in_order("demand", self.demand)
        in_order("surface mu0", self.surface.mu0)
        return self


def rig_scenario(name: str, directory: Path = Path()) -> RigScenario:
    """Return a scenario of the rig by name or path; see `load_twin`."""
    return load_twin(RigScenario, "rig", name, directory)
