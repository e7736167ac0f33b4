"""The file of a K factor study: dispersions and failures of a brake, with the source of every value."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Self

from pydantic import Field, StrictInt, model_validator

from railgrip.base.errors import ScenarioError
from railgrip.rolling_stock.dispersion import Dispersion, Failures
from railgrip.scenario.load import load, read_toml, validate_table
from railgrip.scenario.merge import merge, read_overrides
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import Name, Seed, Speed, Table, table_error

LIBRARY = Path(__file__).parent / "library"


class Effort(Table):
    """Numbers of draws."""

    runs: Annotated[StrictInt, Field(ge=2, le=100)] = Field(description="independent ones, for the intervals")
    samples: Annotated[StrictInt, Field(ge=20, le=20_000)] = Field(description="of each failure state, each run")


class LoopEffort(Effort):
    """Subset simulation with the controller in the loop."""

    probability: Annotated[float, UnitRange("1", at_least=1e-9, at_most=0.1)] = Field(
        description="of a lower deceleration"
    )


class KFactorSpecification(Table):
    """The file."""

    name: Name
    description: str = ""
    seed: Seed
    scenario: str = Field(
        description="scenario of the stop: a file relative to the folder of this file, or a name of the package"
    )
    speed_steps: tuple[Speed, ...] = Field(description="inner limits of the steps of speed, rising")
    estimate: Effort
    loop: LoopEffort | None = None
    dispersion: Annotated[tuple[Dispersion, ...], Field(min_length=1)]
    failures: Failures

    @model_validator(mode="after")
    def _rising(self) -> Self:
        if list(self.speed_steps) != sorted(set(self.speed_steps)):
            raise table_error(f"speed_steps must rise, got {list(self.speed_steps)} m/s")
        return self


def load_specification(path: Path, overrides: Sequence[str] = ()) -> tuple[KFactorSpecification, Scenario]:
    """Return the study of a file, or of the package by its name, and the scenario that it names.

    Raises:
        ScenarioError: In one of the files; each problem in a sentence.
    """
    ours = LIBRARY / f"{path}.toml"
    path = ours if len(path.parts) == 1 and not path.suffix and ours.is_file() else path
    table = merge(read_toml(path), read_overrides(overrides))
    specification = validate_table(KFactorSpecification, table, directory=path.parent, origin=path.name)
    file = Path(specification.scenario)
    scenario = load(path.parent / file if file.suffix else file)
    if specification.speed_steps and specification.speed_steps[-1] >= scenario.start.speed:
        raise ScenarioError(
            f"{path.name}: speed_steps end at {specification.speed_steps[-1]:g} m/s; they must stay below [start] "
            f"speed of {scenario.name}, {scenario.start.speed:g} m/s"
        )
    return specification, scenario
