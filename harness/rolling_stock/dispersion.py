"""Dispersion and failures of a brake's components, for K_dry of ETCS; each value with its source."""

from typing import Annotated, Literal

from pydantic import Field

from railgrip.base.arrays import Array
from railgrip.scenario.quantity import Magnitude, UnitRange
from railgrip.scenario.table import Table, table_error

Extent = Literal["train", "group", "unit"]
Quantity = Literal[
    "pad_friction", "efficiency", "friction_radius", "pressure", "wheel_radius", "mass", "build_up", "track_brake",
    "dynamic_brake",
]  # fmt: skip

EXTENTS: tuple[Extent, ...] = ("train", "group", "unit")
"""A group is what shares a brake valve; a unit is a brake unit."""
_FINEST: dict[Quantity, Extent] = {
    "pressure": "group", "wheel_radius": "group", "mass": "train", "build_up": "group", "track_brake": "train",
    "dynamic_brake": "train",
}  # fmt: skip
_WIDEST = 0.15
"""Maximum relative standard deviation: with a larger one, a factor six deviations below is not positive."""
_FARTHEST = 0.5


_Source = Annotated[
    str, Field(min_length=3, description="publication of these numbers, or what they are estimated from")
]


class _Dispersion(Table):
    """Keys of every entry of [[dispersion]]."""

    quantity: Quantity = Field(description="what deviates: a factor on its nominal value, or a difference of pressure")
    per: Extent = Field(description="what is drawn separately")
    source: _Source

    def _deviation(self, name: str) -> float:
        try:
            return getattr(self, name).si("Pa" if self.quantity == "pressure" else "1")
        except ValueError as problem:
            raise table_error(f"{name} of {self.quantity} {problem}") from problem

    def _check(self) -> None:
        finest = _FINEST.get(self.quantity, "unit")
        if EXTENTS.index(self.per) > EXTENTS.index(finest):
            raise table_error(f"{self.quantity} per {self.per}: there is one for each {finest} at most")


class Normal(_Dispersion):
    """A deviation from nominal with zero mean, normally distributed."""

    kind: Literal["normal"] = Field(description="normal distribution")
    deviation: Magnitude = Field(description="standard deviation")

    def _check(self) -> None:
        sigma = self._deviation("deviation")
        if sigma < 0 or (self.quantity != "pressure" and sigma > _WIDEST):
            raise table_error(f"deviation of {self.quantity} must be between 0 and {_WIDEST:g}, got {sigma:g}")

    def of(self, standard: Array) -> Array:
        """Return deviations for standard normal numbers, as a share of nominal or in Pa."""
        return self._deviation("deviation") * standard


class Uniform(_Dispersion):
    """A deviation from nominal, uniformly distributed between two limits."""

    kind: Literal["uniform"] = Field(description="uniform distribution")
    lowest: Magnitude = Field(description="lower limit of the deviation")
    highest: Magnitude = Field(description="upper limit of the deviation")

    def _check(self) -> None:
        lowest, highest = self._deviation("lowest"), self._deviation("highest")
        if lowest >= highest:
            raise table_error(f"lowest of {self.quantity}, {lowest:g}, must be below highest, {highest:g}")
        if self.quantity != "pressure" and max(-lowest, highest) > _FARTHEST:
            raise table_error(
                f"{self.quantity} must stay within {_FARTHEST:g} of nominal, got {lowest:g} to {highest:g}"
            )

    def of(self, standard: Array) -> Array:
        """Return deviations for standard normal numbers, as a share of nominal or in Pa."""
        from scipy.special import ndtr  # takes longer to import than to read a train

        lowest, highest = self._deviation("lowest"), self._deviation("highest")
        return lowest + (highest - lowest) * ndtr(standard)


Dispersion = Annotated[Normal | Uniform, Field(discriminator="kind")]


class CommonCause(Table):
    """Common-cause failures of several components, by the beta-factor model of IEC 61508-6, annex D."""

    beta: Annotated[float, UnitRange("1", between=(0, 0.5))] = Field(
        description="share of a component's failures that all components of its set have at once"
    )
    source: _Source


class FailureProbability(Table):
    """Probability that a component has failed when the train brakes, and its uncertainty."""

    probability: Annotated[float, UnitRange("1", between=(0, 0.1))] = Field(
        description="median of the probability that it has failed when the train brakes"
    )
    error_factor: Annotated[float, UnitRange("1", between=(1, 100))] = Field(
        description="95 % quantile over median of the lognormal distribution of the probability, which is its median"
    )
    source: _Source

    def quantile(self, standard: float) -> float:
        """Return the probability a number of standard deviations of its logarithm above the median, limited to 1."""
        from scipy.special import ndtri  # as above

        return min(self.probability * self.error_factor ** (standard / float(ndtri(0.95))), 1.0)


class ComponentFailure(FailureProbability):
    """The same of one of several components, with their common-cause failures."""

    common_cause: CommonCause = Field(description="failures that several components have at once")


class Failures(Table):
    """Components that fail."""

    isolated_unit: ComponentFailure = Field(
        description="a brake unit without force; units of a group share a common cause"
    )
    stuck_valve: ComponentFailure = Field(
        description="a group whose vent valve stays open; all valves of the train share a common cause"
    )
    dynamic_brake: FailureProbability | None = Field(
        default=None,
        description="all electrodynamic and eddy-current brakes of the train without force, so that friction brakes "
        "replace those that relieve them; needed for K factors of a train that has them",
    )
