"""The shape of the creep curve: a named set of Polach's parameters, or four numbers.

A named set is a file in the folder `creep_curves`. Broad curves, whose peak is at or above the 10 to 15 % of slip-based
control, are soap and leaf; sharp ones those of the wheelset study.
"""

import tomllib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, Field, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from railgrip.base import registry
from railgrip.base.names import did_you_mean
from railgrip.base.units import short
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.surface import Recovery
from railgrip.scenario.table import optional, table_error


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
        UnitRange(
            "s/m", at_least=0, at_most=100, usual=(0.0, 2.0), because="friction falls over some m/s of slip velocity"
        ),
        Field(description="decay of friction with slip velocity"),
    ]
    temperature_loss: Annotated[
        float, UnitRange("1/K", at_least=0, at_most=1e-2, because="friction falls over some hundred kelvin")
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
