"""The tables [[faults]] and [truth]: component faults, and differences of the true train from the nominal one."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, Final, Literal

from pydantic import Field, StrictInt

from railgrip.base import registry
from railgrip.base.errors import ScenarioError
from railgrip.scenario.quantity import Magnitude, UnitRange, in_units
from railgrip.scenario.table import ONE_OR_EACH, Delay, Table, by_kind, ends_after_it_begins, optional
from railgrip.scenario.track import Slope

READ_BY: Final[Mapping[str, str]] = MappingProxyType(
    {
        "speed_sensor": "wheelset_speed",
        "radar": "speed",
        "accelerometer": "acceleration",
        "transducer": "cylinder_pressure",
        "deflection_sensor": "deflection",
    }
)
"""Quantity that each sensor reads."""

Place = Annotated[StrictInt, Field(ge=1, le=256)]
"""Number of a group or wheelset."""


class Fault(Table):
    """A component fault with a beginning and an end.

    Each kind is a subclass in a module of `railgrip.simulate.faults`, with its keys and, by the methods here, its
    effects.
    """

    part: Any  # each class lists its names as literals
    kind: Any
    begin: Delay = Field(default=0.0, description="since the start of the stop")
    end: Delay | None = optional("without it, the end of the stop")

    _check = ends_after_it_begins

    @property
    def lasts(self) -> bool:
        """Whether it lasts for the whole stop."""
        return not self.begin and self.end is None

    def samples(self, period: float, horizon: float) -> dict[str, int]:
        """Return `begin`, the first sample of a stop with the fault, and `end`, the first sample after it.

        Args:
            period: Time between two samples [s].
            horizon: Maximum duration of the stop [s].
        """
        end = horizon + 1.0 if self.end is None else self.end
        # Times are rounded to the nearest sample; a fault lasts at least one.
        begin = round(self.begin / period)
        return {"begin": begin, "end": max(round(end / period), begin + 1)}

    def act_on(self, site: Any) -> None:
        """Add its faults of single readings and commands to the stop; see `railgrip.simulate.faults.site.Site`."""


def kinds_of_faults() -> dict[str, type[Table]]:
    """Return kind → table of all faults."""
    return by_kind(*registry.parts(registry.FAULTS, Fault))


def amount_of(value: Magnitude, unit: str, where: str, kind: str = "") -> float:
    """Return the value of a fault in a unit.

    Args:
        value: Value as written.
        unit: SI unit.
        where: Opening words of messages.
        kind: Kind of the fault if its value must be above 0, else ''.

    Raises:
        ScenarioError: The value has another dimension, or is not above 0.
    """
    amount = in_units(where, {"value": value}, {"value": unit})["value"]
    if kind and amount <= 0.0:
        raise ScenarioError(f"{where} value must be above 0 for kind '{kind}', got {amount:g}")
    return amount


_Factor = Annotated[
    float,
    UnitRange(
        "1", above=0, at_most=10, usual=(0.3, 2.5), because="factors are about 1, and 0.9 is 10 % less than nominal"
    ),
]


_Factors = Annotated[tuple[_Factor, ...], ONE_OR_EACH, Field(min_length=1)]

_RadiusFactor = Annotated[
    float,
    UnitRange(
        "1", above=0, at_most=10, usual=(0.85, 1.15), because="worn wheels have 90 % of their new radius or more"
    ),
]


TRUTH_KEYS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "m_wheelset": "load", "r_wheel": "wheel_radius", "J": "inertia", "mu_b_nominal": "pad_friction",
        "mu_b_start": "pad_friction", "eta_rigging": "efficiency",
    }
)  # fmt: skip
"""Parameter of a plant → key of [truth]."""


class Truth(Table):
    """Differences of the true train from the one that controller, estimator and driver assume: factors on nominal data.

    A factor is one number for all, or a list by wheelset (load) or by group (others).
    """

    load: _Factors = Field(default=(1.0,), description="on the mass on each wheelset")
    wheel_radius: Annotated[tuple[_RadiusFactor, ...], ONE_OR_EACH, Field(min_length=1)] = Field(
        default=(1.0,), description="on the rolling radius of each group"
    )
    inertia: _Factors = Field(default=(1.0,), description="on the rotating inertia of each group")
    pad_friction: _Factors = Field(default=(1.0,), description="on the friction of the pads of each group")
    efficiency: _Factor = Field(default=1.0, description="on that of the brake rigging")
    creep: dict[Literal["k_A", "k_S", "A_falling", "B_falling"], _Factor] = Field(
        default={}, description="on parameters of the creep curve"
    )
    mechanics: Literal["simple", "detailed"] = Field(
        default="simple",
        description="of contacts and axles; detailed: contact forces by Kalker's simplified theory, except where "
        "contacts heat up, shafts that twist between wheels and brake discs, hysteresis of the brake rigging, and an "
        "uneven rail",
    )
    gradient: Slope = Field(
        default=0.0, description="slope of the whole track in addition to that of [track], positive uphill"
    )

    def factors(self) -> dict[str, tuple[float, ...]]:
        """Return the factors by parameter name of the plants, without those that are 1."""
        values = {name: getattr(self, key) for name, key in TRUTH_KEYS.items()} | self.creep
        every = {name: value if isinstance(value, tuple) else (value,) for name, value in values.items()}
        return {name: factors for name, factors in every.items() if any(factor != 1.0 for factor in factors)}
