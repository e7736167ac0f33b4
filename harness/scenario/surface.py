"""How slip and sand change the rail: the tables [adhesion.recovery], [adhesion.sand] and [[sanders]]."""

from typing import Annotated

from pydantic import Field, StrictInt, model_validator

from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.table import Delay, Friction, Table, ends_after_it_begins, optional


class Recovery(Table):
    """Cleaning of the rail by slip energy, for the wheel that slips and for those behind it.

    Source: Allotta, Meli, Ridolfi and Rindi, Tribology International 69 (2014) 128; the law is in
    `railgrip.simulate.loop.rail.SlipEnergy`.
    """

    mu0: Friction = Field(description="maximum friction of the clean rail; where friction is higher it stays")
    A: Annotated[float, UnitRange("1", above=0, at_most=1), Field(description="of the clean rail, as in polach")]
    B: Annotated[float, UnitRange("s/m", at_least=0, at_most=100), Field(description="of the clean rail, as in polach")]
    rate: Annotated[
        float,
        UnitRange("m/J", at_least=0, at_most=1, because="the energy of slip is some 100 J/m to 10 kJ/m of a wheel"),
    ] = Field(description="τ, of the recovery over the energy of the slip of a wheel on a metre of rail")


_Density = Annotated[
    float,
    UnitRange("kg/m", above=0, at_most=1, usual=(1e-4, 0.1), because="a kilogram on a metre of rail is a heap"),
]


class Sand(Table):
    """Effect of sand on the rail: a density d closes the share 1 − e^(−d/density) of the gap of friction to `mu0`."""

    mu0: Friction = Field(
        description="maximum friction of a rail with plenty of sand; where friction is higher it stays"
    )
    density: _Density = Field(description="on one rail, with which 63 % of the gap are closed")
    left: Annotated[float, UnitRange("1", at_least=0, at_most=1)] = Field(
        description="share of what a wheelset meets that is still there for the next one"
    )


class Sander(Table):
    """A pair of nozzles that strew sand on both rails in front of a wheelset."""

    wheelset: Annotated[StrictInt, Field(ge=1, le=256)] = Field(description="in the direction of travel, from 1 on")
    rate: Annotated[
        float,
        UnitRange("kg/s", at_least=1e-6, at_most=1, usual=(1e-3, 0.2), because="sanders lay some kilograms a minute"),
    ] = Field(description="on one rail; of one whose rate varies, the most")
    density: _Density | None = optional("that it keeps on the rail while `rate` allows; without it, `rate`")
    begin: Delay = Field(default=0.0, description="when it is switched on, since the start of the stop")
    end: Delay | None = optional("without it, the end of the stop")
    delay: Annotated[
        float,
        UnitRange("s", at_least=1e-3, at_most=600, or_zero=True, usual=(0.02, 10.0), because="sand falls a metre"),
    ] = Field(description="that sand takes from the box to the rail, after both")

    _in_order = model_validator(mode="after")(ends_after_it_begins)
