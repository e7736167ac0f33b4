"""Pieces of C source."""

import json
from collections.abc import Sequence


def table(type_: str, name: str, values: Sequence[float]) -> str:
    """Return a C table of numbers."""
    # One entry more, because C has no empty arrays.
    listed = ", ".join([*(repr(float(v)) if type_ == "double" else str(int(v)) for v in values), "0"])
    return f"static const {type_} {name}[] = {{ {listed.replace('inf', 'INFINITY').replace('nan', 'NAN')} }};"


def names(name: str, values: Sequence[str]) -> str:
    """Return a C table of strings."""
    return f"static const char *const {name}[] = {{ {', '.join([*map(quoted, values), '0'])} }};"


def quoted(text: str) -> str:
    """Return a C string literal."""
    return json.dumps(text)
