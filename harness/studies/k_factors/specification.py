"""The file of a K factor study: dispersions and failures of a brake, with the source of every value."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, StrictInt, model_validator

from railgrip.base.errors import ScenarioError
from railgrip.rolling_stock.check import checked_train
from railgrip.rolling_stock.dispersion import Dispersion, Failures
from railgrip.rolling_stock.schema import Train
from railgrip.scenario.file import locate, merge, read_overrides
from railgrip.scenario.load import load, read_toml, validate_table
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import Name, Seed, Speed, Table, table_error
from railgrip.supervision.dispersed import speed_steps
from railgrip.supervision.trains import data_of, maximum_speed

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
    scenario: str | None = Field(
        default=None,
        description="scenario of the stop: a file relative to the folder of this file, or a name of the package; "
        "a train file in place of this file has none",
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


def load_specification(path: Path, overrides: Sequence[str] = ()) -> tuple[KFactorSpecification, Scenario | Train]:
    """Return the study of a file, or of the package by its name, and the scenario or train that it is about.

    A train file, or the name of a train, stands for its own study: at most seven steps of speed up to its maximum.

    Raises:
        ScenarioError: In one of the files; each problem in a sentence.
    """
    ours = LIBRARY / f"{path}.toml"
    path = ours if len(path.parts) == 1 and not path.suffix and ours.is_file() else locate(path, "trains")
    table, changes = read_toml(path), read_overrides(overrides)
    if "cars" in table:
        return _study_of_train(checked_train(path), changes, path.name)
    specification = validate_table(KFactorSpecification, merge(table, changes), directory=path.parent, origin=path.name)
    if specification.scenario is None:
        raise ScenarioError(f"{path.name}: has no 'scenario'; it is required")
    file = Path(specification.scenario)
    scenario = load(path.parent / file if file.suffix else file)
    _require_below(specification, path.name, scenario.start.speed, f"[start] speed of {scenario.name}")
    return specification, scenario


def _study_of_train(train: Train, changes: Mapping[str, Any], origin: str) -> tuple[KFactorSpecification, Train]:
    data = data_of(train)
    table = {
        "name": train.name,
        "description": train.description,
        "seed": 2026,
        "speed_steps": [float(step) for step in speed_steps(train, maximum_speed(train))[-2:0:-1]],
        "estimate": {"runs": 20, "samples": 500},
        "dispersion": data.dispersion,
        "failures": data.failures,
    }
    specification = validate_table(KFactorSpecification, merge(table, changes), directory=Path(), origin=origin)
    _require_below(specification, origin, maximum_speed(train), "the maximum speed of the train")
    return specification, train


def _require_below(specification: KFactorSpecification, origin: str, speed: float, name: str) -> None:
    if specification.speed_steps and specification.speed_steps[-1] >= speed:
        raise ScenarioError(
            f"{origin}: speed_steps end at {specification.speed_steps[-1]:g} m/s; they must stay below {name}, "
            f"{speed:g} m/s"
        )
