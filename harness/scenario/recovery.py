"""How slip cleans the rail."""

from typing import Annotated

from pydantic import Field

from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.table import Friction, Table


class Recovery(Table):
    """Cleaning of the rail by slip energy, for the wheel that slips and for those behind it.

    Source: Allotta, Meli, Ridolfi and Rindi, Tribology International 69 (2014) 128; the law is in
    `railgrip.simulate.loop.rail.Field`.
    """

    mu0: Friction = Field(description="maximum friction of the clean rail; where friction is higher it stays")
    A: Annotated[float, UnitRange("1", above=0, at_most=1), Field(description="of the clean rail, as in polach")]
    B: Annotated[float, UnitRange("s/m", at_least=0, at_most=100), Field(description="of the clean rail, as in polach")]
    rate: Annotated[
        float,
        UnitRange("m/J", at_least=0, at_most=1, because="the energy of slip is some 100 J/m to 10 kJ/m of a wheel"),
    ] = Field(description="τ, of the recovery over the energy of the slip of a wheel on a metre of rail")
