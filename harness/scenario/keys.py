"""SI units and meanings of a scenario's keys."""

from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import Any, get_args

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from railgrip.scenario.kinds import ByKind
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.schema import Scenario


@cache
def units_of_keys() -> Mapping[str, str]:
    """Return key, as `start.speed`, → SI unit, without keys whose unit depends on the kind of their table."""
    return _unambiguous((key, entry.unit) for key, entry in _entries(Scenario, "") if isinstance(entry, UnitRange))


@cache
def meanings_of_keys() -> Mapping[str, str]:
    """Return key → description, without keys whose description depends on the kind of their table."""
    return _unambiguous(
        (key, entry.description or "") for key, entry in _entries(Scenario, "") if isinstance(entry, FieldInfo)
    )


def _unambiguous(pairs: Iterable[tuple[str, str]]) -> dict[str, str]:
    texts: dict[str, set[str]] = {}
    for key, text in pairs:
        texts.setdefault(key, set()).add(text)
    return {key: text for key, (text, *others) in texts.items() if not others}


def _entries(table: type[BaseModel], path: str) -> Iterator[tuple[str, FieldInfo | UnitRange]]:
    for name, field in table.model_fields.items():
        yield f"{path}{name}", field
        yield from _of_annotation(field.annotation, field.metadata, f"{path}{name}")


def _of_annotation(annotation: Any, metadata: Iterable[Any], key: str) -> Iterator[tuple[str, FieldInfo | UnitRange]]:
    for entry in metadata:
        if isinstance(entry, FieldInfo):
            yield from _of_annotation(None, entry.metadata, key)
        elif isinstance(entry, UnitRange):
            yield key, entry
        elif isinstance(entry, ByKind):
            for table in entry.ours().values():
                yield from _entries(table, f"{key}.")
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield from _entries(annotation, f"{key}.")
    elif hasattr(annotation, "__metadata__"):
        yield from _of_annotation(annotation.__origin__, annotation.__metadata__, key)
    else:
        for argument in get_args(annotation):
            yield from _of_annotation(argument, (), key)
