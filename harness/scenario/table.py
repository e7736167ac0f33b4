"""What all tables of a scenario file share: strictness, common quantities, and how a broken rule is said."""

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict
from pydantic_core import PydanticCustomError

from harness.scenario.quantity import Magnitude, Unit

WHEELSETS = 6
GROUPS = 4

Friction = Annotated[float, Unit("1", above=0, at_most=1)]
Speed = Annotated[float, Unit("m/s", above=0)]
Duration = Annotated[float, Unit("s", above=0)]
Delay = Annotated[float, Unit("s", at_least=0)]
Length = Annotated[float, Unit("m", at_least=0)]
Deviation = Annotated[float, Unit("1", at_least=0, below=1)]
Parameters = dict[str, Magnitude]


def broken(words: str) -> PydanticCustomError:
    """Return the refusal of a key or table; the words follow its name in the sentence."""
    return PydanticCustomError("scenario", "{words}", {"words": words})


class Table(BaseModel):
    """A table of the file: frozen, and without unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


def scalars(written: Any) -> Any:
    """Return a parameter table with `x = [1, 2]` made `"x[1]" = 1`, `"x[2]" = 2`, as FMI names them."""
    if not isinstance(written, dict):
        return written
    flat: dict[str, Any] = {}
    for name, value in written.items():
        if isinstance(value, list | tuple):
            flat.update({f"{name}[{index}]": element for index, element in enumerate(value, start=1)})
        else:
            flat[name] = value
    return flat
