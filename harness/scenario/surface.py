"""The surface of the rail: creep curve, cleaning by slip and sand; their tables, and their state in a stop.

A named creep curve is a file in the folder `creep_curves`. Broad curves, whose peak is at or above the 10 to 15 % of
slip-based control, are soap and leaf; sharp ones those of the wheelset study.
"""

import tomllib
from collections.abc import Mapping, Sequence
from functools import cache
from math import inf
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, GetJsonSchemaHandler, StrictInt, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from railgrip.base import registry
from railgrip.base.names import did_you_mean
from railgrip.base.units import short
from railgrip.kernel import kernel
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.table import Delay, Friction, Table, ends_after_it_begins, optional, table_error
from railgrip.vehicle.formation import Formation
from railgrip.vehicle.signals import Layout

_CELL = 0.1
"""Length of a cell [m]: short compared with a bogie, of some 2 m, and with patches of friction, of some 5 m.

The effect of a wheelset's own energy, W, does not depend on it.
"""


class Recovery(Table):
    """Cleaning of the rail by slip energy, for the wheel that slips and for those behind it.

    Source: Allotta, Meli, Ridolfi and Rindi, Tribology International 69 (2014) 128; the law is that
    of `SlipEnergy`.
    """

    mu0: Friction = Field(description="maximum friction of the clean rail; where friction is higher it stays")
    A: Annotated[float, UnitRange("1", above=0, at_most=1), Field(description="of the clean rail, as in polach")]
    B: Annotated[float, UnitRange("s/m", between=(0, 100)), Field(description="of the clean rail, as in polach")]
    rate: Annotated[
        float,
        UnitRange("m/J", between=(0, 1), because="the energy of slip is some 100 J/m to 10 kJ/m of a wheel"),
    ] = Field(description="τ, of the recovery over the energy of the slip of a wheel on a metre of rail")


_Density = Annotated[
    float, UnitRange("kg/m", above=0, at_most=1, usual=(1e-4, 0.1), because="a kilogram on a metre of rail is a heap")
]


class Sand(Table):
    """Effect of sand on the rail: a density d closes the share 1 − e^(−d/density) of the gap of friction to `mu0`."""

    mu0: Friction = Field(
        description="maximum friction of a rail with plenty of sand; where friction is higher it stays"
    )
    density: _Density = Field(description="on one rail, with which 63 % of the gap are closed")
    left: Annotated[float, UnitRange("1", between=(0, 1))] = Field(
        description="share of what a wheelset meets that is still there for the next one"
    )


class Sander(Table):
    """A pair of nozzles that strew sand on both rails in front of a wheelset."""

    wheelset: Annotated[StrictInt, Field(ge=1, le=256)] = Field(description="in the direction of travel, from 1 on")
    rate: Annotated[
        float,
        UnitRange("kg/s", between=(1e-6, 1), usual=(1e-3, 0.2), because="sanders lay some kilograms a minute"),
    ] = Field(description="on one rail; of one whose rate varies, the most")
    density: _Density | None = optional("that it keeps on the rail while `rate` allows; without it, `rate`")
    begin: Delay = Field(default=0.0, description="when it is switched on, since the start of the stop")
    end: Delay | None = optional("without it, the end of the stop")
    delay: Annotated[
        float,
        UnitRange("s", between=(1e-3, 600), or_zero=True, usual=(0.02, 10.0), because="sand falls a metre"),
    ] = Field(description="that sand takes from the box to the rail, after both")

    _check = ends_after_it_begins


class SlipEnergy:
    """The slip energy left on the rail, cell by cell, and the friction that it restores.

    A wheel with adhesion force F and slip s dissipates W = F s on each metre of its rail. If earlier wheels have left
    the sum E and the present one dissipates W, friction is

        f = f_d + λ (max(f_r, f_d) − f_d),   λ = 1 − e^(−τ (E + W)),   f_i = mu0_i ((1 − A_i) e^(−B_i w) + A_i)

    with the slip speed w, f_d of the untreated rail and f_r of the clean one. A wheel with high slip thus gains
    friction itself, and each one behind it starts from the friction that those ahead have restored. The two wheels of a
    wheelset share its force. A wheelset uses the E that its cell had when it got there; its own W is added when it
    leaves.

    Source: Allotta, Meli, Ridolfi and Rindi, Tribology International 69 (2014) 128, and Meccanica 49 (2014) 919, for
        one wheel (E = 0). Summing E over wheels is the same law for a film that wears independently of the wheel: 1 − λ
        = e^(−τ W1) e^(−τ W2).

    Limits: creep stiffness (k_A, k_S) stays that of the untreated rail, and the cleaning of a wheel's own tread is
        included in τ. W is that of the previous sample.

    Attributes:
        energy: Slip energy left in each cell by the wheelsets that have passed it, per wheel [J/m].
        origin: Start of the first cell, behind the last wheelset's initial position [m].
    """

    def __init__(self, layout: Layout, clean: Recovery, falling: tuple[float, float], reach: float) -> None:
        """Create a rail that no wheel has cleaned.

        Args:
            layout: Layout of the vehicle on it; its formation has the positions of the wheelsets.
            clean: Friction of the cleaned rail, and the rate of cleaning.
            falling: A and B [s/m] of the plant's creep curve, the fall of friction with slip speed.
            reach: Distance that the train may cover [m].
        """
        formation = layout.formation
        position, self.origin, self.energy = _cells(formation, reach)
        self.struct = kernel(layout).struct("Recovery", energy=self.energy, position=position,
            group=np.ascontiguousarray(formation.group_of_wheelset, dtype=np.longlong), origin=self.origin,
            length=_CELL, rate=clean.rate, clean=clean.mu0, clean_A=clean.A, clean_B=clean.B,
            A=[falling[0]] * formation.wheelsets, B=[falling[1]] * formation.wheelsets, cells=self.energy.size,
        )  # fmt: skip


class SandedRail:
    """Sand on the rail, cell by cell, and the resulting friction.

    A sander deposits d = min(rate / v, density) on each metre of either rail in front of its wheelset at speed v. A
    wheelset that meets d, deposited there or left by those ahead, has the maximum friction

        mu0 + (1 − e^(−d / density)) max(mu0_sand − mu0, 0)

    and leaves the share `left` of d to the next one: the rest is crushed, blown away or carried off. Each wheelset
    behind a sander thus has less sand, and one that stops over its own sand has plenty.

    Friction saturates with the sand on the rail, and most sand misses the contact: Lewis, Riley, Fletcher and Lewis,
    Int. J. Railway Technology 6 (2017) 87, and Proc. IMechE F 232 (2018) 43. The constant share and the exponential are
    assumptions of this model.

    A controller that demands sand, such as `deceleration_control`, switches all sanders within their times.

    Attributes:
        deposited: Sand on each cell of either rail, for the wheelsets to come [kg/m].
        origin: Start of the first cell, behind the last wheelset's initial position [m].
        is_demanded: Whether a controller switches the sanders.

    Limits: the rails stay dry, and wheels do not carry sand around. Creep stiffness and the fall with slip speed stay
        those of the untreated rail, and sand leaves the nozzle at the rate of the present speed.
    """

    def __init__(self, layout: Layout, sanders: Sequence[Sander], reach: float, sand: Sand) -> None:
        """Create a rail without sand.

        Args:
            layout: Layout of the vehicle on it; its formation has the positions of the wheelsets.
            sanders: The sanders of the train.
            reach: Distance that the train may cover [m].
            sand: Effect of sand on friction.
        """
        position, self.origin, self.deposited = _cells(layout.formation, reach)
        self.is_demanded = False
        rows = kernel(layout).records("Sander", len(sanders))
        for row, sander in zip(rows, sanders, strict=True):
            row["rate"], row["density"] = sander.rate, inf if sander.density is None else sander.density
            row["begin"] = sander.begin + sander.delay
            row["end"] = inf if sander.end is None else sander.end + sander.delay
            row["wheelset"], row["delay"] = sander.wheelset - 1, sander.delay
        self.struct = kernel(layout).struct(
            "Sand", deposited=self.deposited, position=position, sanders=rows, origin=self.origin, length=_CELL,
            mu0=sand.mu0, density=sand.density, remaining_share=sand.left, count=len(sanders),
            cells=self.deposited.size,
        )  # fmt: skip

    def follow(self, demand: NDArray[np.float64]) -> None:
        """Switch the sanders by a controller's demand, shape (1,): on from 0.5 on; it is read at each sample."""
        self.struct.set(is_demanded=demand)
        self.is_demanded = True


def _cells(formation: Formation, reach: float) -> tuple[NDArray[np.float64], float, NDArray[np.float64]]:
    """Return positions of wheelsets, start of the first cell, and zeros for all cells up to one beyond `reach`."""
    position = formation.position
    assert position is not None  # `railgrip.scenario.adhesion.rail_of` requires it
    origin = -float(position[-1]) - _CELL
    return position, origin, np.zeros(int((reach - origin) / _CELL) + 2)


def named_set(name: str) -> Mapping[str, Any]:
    """Return the entries of a named creep curve but its source.

    Raises:
        PydanticCustomError: The name is unknown.
    """
    files = registry.files(registry.CREEP_CURVES)
    if name not in files:
        raise table_error(
            f"is {short(name)}, which is not a Polach set; there are {', '.join(files)}, or give k_A, k_S, A and B"
            + did_you_mean(name, files, before="; ")
        )
    return _numbers(files[name])


@cache
def _numbers(file: Path) -> Mapping[str, Any]:
    table = tomllib.loads(file.read_text(encoding="utf-8"))
    return {name: value for name, value in table.items() if name != "source"}


class Polach(BaseModel):
    """Shape of the creep curve; its height, mu0, is the profile's.

    Source: Polach, Wear 258 (2005) 992.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str = Field(default="own", description="the named set that the numbers come from")
    k_A: Annotated[  # noqa: N815 (the name in the literature)
        float, UnitRange("1", above=0, at_most=1), Field(description="slope reduction, area of adhesion")
    ]
    k_S: Annotated[  # noqa: N815 (the name in the literature)
        float, UnitRange("1", above=0, at_most=1), Field(description="slope reduction, area of slip")
    ]
    A: Annotated[
        float,
        UnitRange("1", above=0, at_most=1, usual=(0.05, 1.0), because="published curves have 0.1 to 0.5"),
        Field(description="friction at infinite slip velocity over mu0"),
    ]
    B: Annotated[
        float,
        UnitRange("s/m", between=(0, 100), usual=(0.0, 2.0), because="friction falls over some m/s of slip velocity"),
        Field(description="decay of friction with slip velocity"),
    ]
    temperature_loss: Annotated[
        float, UnitRange("1/K", between=(0, 1e-2), because="friction falls over some hundred kelvin")
    ] = optional("share of friction that the contact loses per kelvin of its temperature rise", default=0.0)
    recovery: Recovery | None = optional("how slip cleans the rail, where [adhesion] has no recovery")

    @model_validator(mode="before")
    @classmethod
    def _name_or_numbers(cls, entry: Any) -> Any:
        return {"name": entry, **named_set(entry)} if isinstance(entry, str) else entry

    @classmethod
    def __get_pydantic_json_schema__(cls, source: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Return the schema of a name or of the numbers."""
        names = list(registry.files(registry.CREEP_CURVES))
        return {"description": "name of a creep curve, or its numbers", "anyOf": [{"enum": names}, handler(source)]}

    @model_validator(mode="after")
    def _stays_below_friction(self) -> Self:
        # Otherwise 2/π (k_A ε/(1 + (k_A ε)²) + arctan(k_S ε)), the share of mu0 that the contact uses, exceeds 1.
        if self.k_S > self.k_A:
            raise table_error(
                f"has k_S {self.k_S:g} above k_A {self.k_A:g}, with which the wheel would use more than mu0; "
                "k_S <= k_A <= 1 (Polach, 2005)"
            )
        return self

    def plant_parameters(self) -> dict[str, float]:
        """Return Polach's numbers by parameter name of the plant FMUs."""
        return {"k_A": self.k_A, "k_S": self.k_S, "A_falling": self.A, "B_falling": self.B}

    def contact_parameters(self) -> dict[str, float]:
        """Return all numbers of the contact by parameter name of the plant FMUs."""
        heat = {"temperature_loss": self.temperature_loss} if self.temperature_loss else {}
        return self.plant_parameters() | heat
