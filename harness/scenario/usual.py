"""Find values of tables outside of their usual ranges; see `UnitRange.usual`."""

from collections.abc import Iterator, Mapping
from typing import Any, cast, get_args

from pydantic import BaseModel

from railgrip.scenario.quantity import UnitRange


def unusual(table: BaseModel, key: str = "") -> Iterator[tuple[str, str]]:
    """Yield the key of each unusual value of a table and of the tables in it, as `[start] speed`, with its description.

    The description follows the key, as in `is 500 m/s; usual are …`.

    Args:
        table: Table of a file.
        key: Key of that table; empty for the whole file.
    """
    for name, field in type(table).model_fields.items():
        value, path = getattr(table, name), f"{key}.{name}" if key else name
        for place, inner in _elements(path, value):
            if isinstance(inner, BaseModel):
                yield from unusual(inner, place)
                continue
            span = _range_of(field.annotation, field.metadata)
            if span is not None and isinstance(inner, float) and (words := span.doubt(inner)):
                where, _, last = place.rpartition(".")
                yield f"[{where}] {last}", words


def _elements(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for name, inner in cast("Mapping[str, Any]", value).items():
            yield from _elements(f"{path}.{name}", inner)
    elif isinstance(value, tuple):
        values = cast("tuple[Any, ...]", value)
        for number, inner in enumerate(values, start=1):
            yield from _elements(
                f"{path}[{number}]" if len(values) > 1 or isinstance(inner, BaseModel) else path, inner
            )
    else:
        yield path, value


def _range_of(annotation: Any, metadata: Any = ()) -> UnitRange | None:
    for entry in (*metadata, *getattr(annotation, "__metadata__", ())):
        if isinstance(entry, UnitRange):
            return entry
    return next((found for part in get_args(annotation) if (found := _range_of(part)) is not None), None)
