"""The tables [[faults]] and [truth]: what is broken, and what the train is that nobody told its controller."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Final, Literal, Self

from pydantic import Field, StrictInt, model_validator

from railgrip.errors import ScenarioError
from railgrip.scenario.quantity import Magnitude, Unit, in_units
from railgrip.scenario.table import ONE_OR_EACH, Delay, Table, broken, optional
from railgrip.scenario.track import STEEPEST

Part = Literal["speed_sensor", "radar", "accelerometer", "transducer", "deflection_sensor", "valve", "brake", "supply"]
Kind = Literal[
    "dead", "stuck", "zero", "scaled", "biased", "noisy", "missing_teeth",
    "filled", "dumped", "held", "slow", "isolated", "sagging",
]  # fmt: skip

READ_BY: Final[Mapping[Part, str]] = MappingProxyType(
    {
        "speed_sensor": "wheelset_speed",
        "radar": "speed",
        "accelerometer": "acceleration",
        "transducer": "cylinder_pressure",
        "deflection_sensor": "deflection",
    }
)
"""What each sensor reads."""

_SENSOR: Final[tuple[Kind, ...]] = ("dead", "stuck", "zero", "scaled", "biased", "noisy")
KINDS: Final[Mapping[Part, tuple[Kind, ...]]] = {
    "speed_sensor": (*_SENSOR, "missing_teeth"),
    "radar": _SENSOR,
    "accelerometer": _SENSOR,
    "transducer": _SENSOR,
    "deflection_sensor": _SENSOR,
    "valve": ("filled", "dumped", "held", "slow"),
    "brake": ("isolated",),
    "supply": ("sagging",),
}
"""What may be wrong with each part."""

_VALUED: Final = frozenset({"scaled", "biased", "noisy", "missing_teeth", "slow", "sagging"})
_UNITS: Final[Mapping[Kind, str]] = MappingProxyType(
    {"scaled": "1", "missing_teeth": "1", "slow": "s", "isolated": "1", "sagging": "m3"}
)
_OF_WHOLE_TRAIN: Final = frozenset({"radar", "accelerometer", "supply"})


_Place = Annotated[StrictInt, Field(ge=1, le=256)]


class Fault(Table):
    """Something that is broken for a while."""

    part: Part
    kind: Kind
    group: _Place | None = optional("from 1 on; without it all groups")
    wheelset: _Place | None = optional("in place of `group`, of a deflection sensor; without it all")
    begin: Delay = Field(default=0.0, description="since the start of the stop")
    end: Delay | None = optional("without it, the end of the stop")
    value: Magnitude | None = optional(
        "scaled: factor; biased: what is added; noisy: 1σ of what is added; missing_teeth: how many, in a "
        "row; slow: added dead time; isolated: units of the group, without it all; sagging: volume of the reservoir"
    )
    pressure: Annotated[float, Unit("Pa", above=0, at_most=1e8)] | None = optional(
        "of the full reservoir, of a supply that sags"
    )
    refill: (
        Annotated[float, Unit("m3/s", above=0, at_most=1, because="compressors deliver some m3 a minute")] | None
    ) = optional("free air that its compressor delivers; without it, none")

    @model_validator(mode="after")
    def _makes_sense(self) -> Self:
        if self.kind not in KINDS[self.part]:
            raise broken(
                f"kind '{self.kind}' is nothing that a {self.part} does; it may be {', '.join(KINDS[self.part])}"
            )
        where = "wheelset" if self.part == "deflection_sensor" else "group"
        for name in ("group", "wheelset"):
            if getattr(self, name) is not None and (self.part in _OF_WHOLE_TRAIN or name != where):
                choice = "no place: there is one" if self.part in _OF_WHOLE_TRAIN else f"'{where}'"
                raise broken(f"has '{name}', but {self.part} takes {choice}")
        if self.end is not None and self.end <= self.begin:
            raise broken(f"end {self.end:g} s is not after begin {self.begin:g} s")
        if self.kind != "isolated" and (self.value is None) == (self.kind in _VALUED):
            raise broken(f"kind '{self.kind}' {'wants a' if self.value is None else 'takes no'} value")
        if (self.pressure is None) == (self.kind == "sagging"):
            raise broken(f"kind '{self.kind}' {'wants the' if self.pressure is None else 'takes no'} pressure")
        if self.refill is not None and self.kind != "sagging":
            raise broken(f"kind '{self.kind}' takes no refill")
        return self

    def amount(self, unit: str, where: str) -> float:
        """Return `value`, 0 where there is none.

        Args:
            unit: Of what the sensor reads, for the kinds that are measured in it.
            where: To open sentences with.

        Raises:
            ScenarioError: It has another dimension, or cannot be.
        """
        if self.value is None:
            return 0.0
        value = in_units(where, {"value": self.value}, {"value": _UNITS.get(self.kind, unit)})["value"]
        if self.kind in {"noisy", "slow", "sagging", "isolated", "missing_teeth"} and value <= 0.0:
            raise ScenarioError(f"{where} value must be above 0 for kind '{self.kind}', got {value:g}")
        if self.kind == "missing_teeth" and value != round(value):
            raise ScenarioError(f"{where} value is a number of teeth, got {value:g}")
        return value


_Factor = Annotated[float, Unit("1", above=0, at_most=10, because="no train is ten times what it is said to be")]


_Factors = Annotated[tuple[_Factor, ...], ONE_OR_EACH, Field(min_length=1)]


class Truth(Table):
    """What the train is that its controller, estimator and driver were not told: factors on the data they know.

    A factor is one for all or a list: of wheelsets for the load, of groups for what groups have.
    """

    load: _Factors = Field(default=(1.0,), description="on the mass on each wheelset")
    wheel_radius: _Factors = Field(default=(1.0,), description="on the rolling radius of each group")
    inertia: _Factors = Field(default=(1.0,), description="on the rotating inertia of each group")
    pad_friction: _Factors = Field(default=(1.0,), description="on the friction of the pads of each group")
    efficiency: _Factor = Field(default=1.0, description="on that of the brake rigging")
    creep: dict[Literal["k_A", "k_S", "A_falling", "B_falling"], _Factor] = Field(
        default={}, description="on parameters of the creep curve"
    )
    gradient: Annotated[float, Unit("1", above=-STEEPEST, below=STEEPEST)] = Field(
        default=0.0, description="slope of the whole track beside that of [track], positive uphill"
    )

    def factors(self) -> dict[str, tuple[float, ...]]:
        """Return the factors of parameters that plants have by these names, without those that change nothing."""
        every = {
            "m_wheelset": self.load, "r_wheel": self.wheel_radius, "J": self.inertia, "mu_b_nominal": self.pad_friction,
            "mu_b_start": self.pad_friction, "eta_rigging": (self.efficiency,),
            **{name: (factor,) for name, factor in self.creep.items()},
        }  # fmt: skip
        return {name: factors for name, factors in every.items() if any(factor != 1.0 for factor in factors)}


TRUTH_KEYS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "m_wheelset": "load", "r_wheel": "wheel_radius", "J": "inertia", "mu_b_nominal": "pad_friction",
        "mu_b_start": "pad_friction", "eta_rigging": "efficiency",
    }
)  # fmt: skip
"""Parameter of a plant → key of [truth]."""
