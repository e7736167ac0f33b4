"""Parameters of sampled functions, each with its unit and meaning."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, get_type_hints

from railgrip.controllers.sampled import Expression, FormulaBuilder


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters:
    """Parameters of a sampled function; the type of each is `Annotated[float, unit, meaning]`."""

    @classmethod
    @cache
    def meanings(cls) -> Mapping[str, tuple[Any, ...]]:
        """Return the unit, the meaning and, if there is one, the largest value of each parameter, by name."""
        types = get_type_hints(cls, include_extras=True)
        return {field.name: types[field.name].__metadata__ for field in fields(cls)}

    @classmethod
    def declare(cls, draft: FormulaBuilder) -> dict[str, Expression]:
        """Declare all parameters in a draft, and return their symbols by name."""
        return {name: draft.parameter(name, *meaning) for name, meaning in cls.meanings().items()}
