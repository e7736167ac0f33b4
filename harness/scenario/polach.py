"""The shape of the creep curve: a named set of Polach's parameters, or four numbers."""

import tomllib
from functools import cache
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from railgrip.scenario.quantity import Unit

_SETS = Path(__file__).parent / "library" / "polach.toml"


@cache
def named_sets() -> dict[str, dict[str, Any]]:
    """Return the sets of library/polach.toml: name → k_A, k_S, A, B and source."""
    return tomllib.loads(_SETS.read_text(encoding="utf-8"))


class Polach(BaseModel):
    """Shape of the creep curve; its height, mu0, is the profile's.

    Source: Polach, Wear 258 (2005) 992.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str = Field(default="own", description="the named set that the numbers come from")
    k_A: Annotated[  # noqa: N815 (the name in the literature)
        float, Unit("1", above=0, at_most=1), Field(description="slope reduction, area of adhesion")
    ]
    k_S: Annotated[  # noqa: N815 (the name in the literature)
        float, Unit("1", above=0, at_most=1), Field(description="slope reduction, area of slip")
    ]
    A: Annotated[float, Unit("1", above=0, at_most=1), Field(description="friction at infinite slip velocity over mu0")]
    B: Annotated[
        float,
        Unit("s/m", at_least=0, at_most=100, because="friction falls over some m/s of slip velocity"),
        Field(description="decay of friction with slip velocity"),
    ]

    @model_validator(mode="before")
    @classmethod
    def _name_or_numbers(cls, entry: Any) -> Any:
        """Replace the name of a set by its numbers."""
        if not isinstance(entry, str):
            return entry
        sets = named_sets()
        if entry not in sets:
            raise PydanticCustomError(
                "polach",
                "is '{found}', which is not a Polach set; there are {known}, or give k_A, k_S, A and B",
                {"found": entry, "known": ", ".join(sets)},
            )
        return {"name": entry} | {key: value for key, value in sets[entry].items() if key != "source"}

    def plant_parameters(self) -> dict[str, float]:
        """Return the same numbers under the names of the plant FMU's parameters."""
        return {"k_A": self.k_A, "k_S": self.k_S, "A_falling": self.A, "B_falling": self.B}
