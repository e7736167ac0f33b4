"""The SI units of a scenario's keys."""

from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import Any, get_args

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from railgrip.scenario.kinds import ByKind
from railgrip.scenario.quantity import Unit
from railgrip.scenario.schema import Scenario


@cache
def units_of_keys() -> Mapping[str, str]:
    """Return key, as `start.speed`, → SI unit; none for a key whose unit depends on the kind of its table."""
    units: dict[str, set[str]] = {}
    for key, unit in _units(Scenario, ""):
        units.setdefault(key, set()).add(unit)
    return {key: unit for key, (unit, *others) in units.items() if not others}


def _units(table: type[BaseModel], path: str) -> Iterator[tuple[str, str]]:
    for name, field in table.model_fields.items():
        yield from _of_annotation(field.annotation, field.metadata, f"{path}{name}")


def _of_annotation(annotation: Any, metadata: Iterable[Any], key: str) -> Iterator[tuple[str, str]]:
    for entry in metadata:
        if isinstance(entry, FieldInfo):
            yield from _of_annotation(None, entry.metadata, key)
        elif isinstance(entry, Unit):
            yield key, entry.unit
        elif isinstance(entry, ByKind):
            for table in entry.ours().values():
                yield from _units(table, f"{key}.")
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield from _units(annotation, f"{key}.")
    elif hasattr(annotation, "__metadata__"):
        yield from _of_annotation(annotation.__origin__, annotation.__metadata__, key)
    else:
        for argument in get_args(annotation):
            yield from _of_annotation(argument, (), key)
