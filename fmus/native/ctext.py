"""Pieces of C source."""

import ctypes
import json
from collections.abc import Iterable, Sequence
from typing import Any, cast


def table(type_: str, name: str, values: Sequence[float]) -> str:
    """Return a C table of numbers."""
    # One entry more, because C has no empty arrays.
    entries = ", ".join([*(number(v) if type_ == "double" else str(int(v)) for v in values), "0"])
    return f"static const {type_} {name}[] = {{ {entries} }};"


def number(value: float) -> str:
    """Return a number that stands for itself in any C expression."""
    text = repr(float(value)).replace("inf", "INFINITY").replace("nan", "NAN")
    return f"({text})" if text.startswith("-") else text


def names(name: str, values: Sequence[str]) -> str:
    """Return a C table of strings."""
    return f"static const char *const {name}[] = {{ {', '.join([*map(string_literal, values), '0'])} }};"


def in_parts(name: str, parameters: str, parts: Iterable[Sequence[str]]) -> list[str]:
    """Return lines of C functions, one of each part, and of the table NAME_parts of them all.

    Called through a table, because a compiler that sees a function called only once puts it into the caller, and then
    has before it the length that was to be avoided.
    """
    lines: list[str] = []
    own: list[str] = []
    voids = " ".join(f"(void){parameter.split()[-1].lstrip('*')};" for parameter in parameters.split(","))
    for part in parts:
        own.append(f"{name}{len(own)}")
        lines += [f"static void {own[-1]}({parameters}) {{", voids, *part, "}"]
    # One entry more, because C has no empty arrays.
    return [*lines, f"static void (*const {name}_parts[])({parameters}) = {{ {', '.join([*own, '0'])} }};"]


def string_literal(text: str) -> str:
    """Return a C string literal."""
    return json.dumps(text)


_C_TYPES = {"P": "void *", "q": "long long ", "l": "long long ", "d": "double "}


def struct(type_: type[ctypes.Structure]) -> str:
    """Return the C declaration of a ctypes struct of pointers, 64-bit integers and doubles, under its own name."""
    fields = "".join(f"    {_C_TYPES[of._type_]}{name};\n" for name, of in cast(Any, type_)._fields_)
    return f"typedef struct {{\n{fields}}} {type_.__name__.lstrip('_')};\n"
