"""The file of a K factor study: dispersions and failures of a brake, with the source of every value."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, StrictInt, model_validator
from scipy.special import ndtr, ndtri

from railgrip.base.errors import ScenarioError
from railgrip.estimators.belief import Array
from railgrip.scenario.load import load, read_toml, validate_table
from railgrip.scenario.merge import merge, read_overrides
from railgrip.scenario.quantity import Magnitude, UnitRange
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import Name, Seed, Speed, Table, table_error

Extent = Literal["train", "group", "unit"]
Quantity = Literal[
    "pad_friction", "efficiency", "friction_radius", "pressure", "wheel_radius", "mass", "build_up"
]  # fmt: skip

LIBRARY = Path(__file__).parent / "library"
EXTENTS: tuple[Extent, ...] = ("train", "group", "unit")
_FINEST: dict[Quantity, Extent] = {"pressure": "group", "wheel_radius": "group", "mass": "train", "build_up": "train"}
_WIDEST = 0.15
"""Maximum relative standard deviation: with a larger one, a factor six deviations below is not positive."""
_FARTHEST = 0.5


class _Dispersion(Table):
    """Keys of every entry of [[dispersion]]."""

    quantity: Quantity
    per: Extent = Field(description="what is drawn separately")
    source: Annotated[str, Field(min_length=3)]

    def _deviation(self, name: str) -> float:
        try:
            return getattr(self, name).si("Pa" if self.quantity == "pressure" else "1")
        except ValueError as problem:
            raise table_error(f"{name} of {self.quantity} {problem}") from problem

    @model_validator(mode="after")
    def _not_finer_than_it_is(self) -> Self:
        finest = _FINEST.get(self.quantity, "unit")
        if EXTENTS.index(self.per) > EXTENTS.index(finest):
            raise table_error(f"{self.quantity} per {self.per}: there is one for each {finest} at most")
        return self


class Normal(_Dispersion):
    """A deviation from nominal with zero mean, normally distributed."""

    kind: Literal["normal"]
    deviation: Magnitude = Field(description="standard deviation")

    @model_validator(mode="after")
    def _plausible(self) -> Self:
        sigma = self._deviation("deviation")
        if sigma < 0 or (self.quantity != "pressure" and sigma > _WIDEST):
            raise table_error(f"deviation of {self.quantity} must be between 0 and {_WIDEST:g}, got {sigma:g}")
        return self

    def of(self, standard: Array) -> Array:
        """Return deviations for standard normal numbers, as a share of nominal or in Pa."""
        return self._deviation("deviation") * standard


class Uniform(_Dispersion):
    """A deviation from nominal, uniformly distributed between two limits."""

    kind: Literal["uniform"]
    lowest: Magnitude
    highest: Magnitude

    @model_validator(mode="after")
    def _plausible(self) -> Self:
        lowest, highest = self._deviation("lowest"), self._deviation("highest")
        if lowest >= highest:
            raise table_error(f"lowest of {self.quantity}, {lowest:g}, must be below highest, {highest:g}")
        if self.quantity != "pressure" and max(-lowest, highest) > _FARTHEST:
            raise table_error(
                f"{self.quantity} must stay within {_FARTHEST:g} of nominal, got {lowest:g} to {highest:g}"
            )
        return self

    def of(self, standard: Array) -> Array:
        """Return deviations for standard normal numbers, as a share of nominal or in Pa."""
        lowest, highest = self._deviation("lowest"), self._deviation("highest")
        return lowest + (highest - lowest) * ndtr(standard)


Dispersion = Annotated[Normal | Uniform, Field(discriminator="kind")]


class CommonCause(Table):
    """Common-cause failures of several components, by the beta-factor model of IEC 61508-6, annex D."""

    beta: Annotated[float, UnitRange("1", at_least=0, at_most=0.5)] = Field(
        description="share of a component's failures that all components of its set have at once"
    )
    source: Annotated[str, Field(min_length=3)]


class ComponentFailure(Table):
    """Probability that a component has failed when the train brakes, its uncertainty, and common-cause failures."""

    probability: Annotated[float, UnitRange("1", at_least=0, at_most=0.1)]
    error_factor: Annotated[float, UnitRange("1", at_least=1, at_most=100)] = Field(
        description="95 % quantile over median of the lognormal distribution of the probability, which is its median"
    )
    source: Annotated[str, Field(min_length=3)]
    common_cause: CommonCause

    def quantile(self, standard: float) -> float:
        """Return the probability a number of standard deviations of its logarithm above the median, limited to 1."""
        return min(self.probability * self.error_factor ** (standard / float(ndtri(0.95))), 1.0)


class Failures(Table):
    """Components that fail."""

    isolated_unit: ComponentFailure = Field(
        description="a brake unit without force; units of a group share a common cause"
    )
    stuck_valve: ComponentFailure = Field(
        description="a group whose vent valve stays open; all valves of the train share a common cause"
    )


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
