"""Pieces of C source.

Text from outside (names, messages, places) enters C only as a string literal made by `string_literal`.
"""

import string
from collections.abc import Iterable, Sequence


def table(type_: str, name: str, values: Sequence[float]) -> str:
    """Return a C table of numbers."""
    # One entry more, because C has no empty arrays.
    entries = ", ".join([*(number(v) if type_ == "double" else str(int(v)) for v in values), "0"])
    return f"static const {type_} {name}[] = {{ {entries} }};"


def number(value: float) -> str:
    """Return a number as text that is valid in any C expression."""
    text = repr(float(value)).replace("inf", "INFINITY").replace("nan", "NAN")
    return f"({text})" if text.startswith("-") else text


def strings(name: str, values: Sequence[str | None]) -> str:
    """Return a C table of strings, with a null pointer for each None."""
    # One entry more, because C has no empty arrays.
    entries = ["0" if value is None else string_literal(value) for value in (*values, None)]
    return f"static const char *const {name}[] = {{ {', '.join(entries)} }};"


def in_parts(name: str, parameters: str, parts: Iterable[Sequence[str]]) -> list[str]:
    """Return lines of C functions, one for each part, and of the table NAME_parts with all of them.

    They are called through a table, because compilers inline a function that is called only once, and the caller would
    then have the length that the division avoids.
    """
    lines: list[str] = []
    body: list[str] = []
    voids = " ".join(f"(void){parameter.split()[-1].lstrip('*')};" for parameter in parameters.split(","))
    for part in parts:
        body.append(f"{name}{len(body)}")
        lines += [f"static void {body[-1]}({parameters}) {{", voids, *part, "}"]
    # One entry more, because C has no empty arrays.
    return [*lines, f"static void (*const {name}_parts[])({parameters}) = {{ {', '.join([*body, '0'])} }};"]


_PLAIN = frozenset(string.ascii_letters + string.digits + string.punctuation + " ") - frozenset('"\\?')
"""Characters that need no escape in a C string literal; `??` begins a trigraph."""


def string_literal(text: str) -> str:
    """Return a C string literal of a text in UTF-8; NUL, which would end the string, becomes U+FFFD."""
    octets = text.replace("\0", "\ufffd").encode(errors="replace")
    # Always three digits, so that a digit that follows in the text is not read as part of the escape.
    return '"' + "".join(c if (c := chr(octet)) in _PLAIN else f"\\{octet:03o}" for octet in octets) + '"'
