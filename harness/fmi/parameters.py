"""Check parameter values of an FMU against its declarations before any of them is set.

Values are in the unit that the FMU declares for the variable, as in every FMI tool; a parameter that the
harness itself sets in SI goes through `Binding.translate` first.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import cast

from railgrip.base.errors import FmuError
from railgrip.fmi.description import Description, FmuVariable

Scalar = float | int | bool | str
_ROUNDING = 1e-14
"""Relative error of a number that two units were multiplied into: a few times the machine epsilon of 2.2e-16."""
Values = Mapping[str, object]
"""Name → number, boolean, string, or a (nested) list of them for an array `name[i]` or `name[i,j]`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Assignment:
    """Checked values of one FMI type, for one call; arrays of FMI 3.0 are complete."""

    carrier: str
    references: tuple[int, ...]
    values: tuple[Scalar, ...]


def assignments(description: Description, values: Values) -> tuple[Assignment, ...]:
    """Check parameter values and sort them by FMI type.

    Raises:
        FmuError: The FMU lacks a name, a variable cannot be set, or a value has the wrong type or is out of bounds.
    """
    by_type: dict[str, dict[int, list[Scalar]]] = {}
    for name, value in _flat(values):
        variable = description.variable(name, "parameters")
        if not variable.settable or variable.causality == "input":
            raise FmuError(
                f"parameters: '{name}' of {description.file.name} cannot be set, it is "
                f"{'an input' if variable.causality == 'input' else 'calculated or constant'}; "
                f"leave it out. Its parameters: {_some(description)}."
            )
        scalar = _check(variable, value, description.file.name)
        arrays = by_type.setdefault(variable.carrier, {})
        if variable.reference not in arrays:
            arrays[variable.reference] = start_values(description, variable)
        arrays[variable.reference][variable.element] = scalar
    return tuple(
        Assignment(
            carrier=carrier, references=tuple(arrays), values=tuple(v for array in arrays.values() for v in array)
        )
        for carrier, arrays in by_type.items()
    )


def start_values(description: Description, variable: FmuVariable) -> list[Scalar]:
    """Return the start values of all elements of a variable's array, zeros for missing ones; one value for a scalar."""
    plain: dict[str, Callable[[str], Scalar]] = {
        "Real": float, "Boolean": lambda text: text in ("true", "1"), "String": str, "Binary": str,
    }  # fmt: skip
    number = plain.get(variable.kind, lambda text: int(float(text)))
    values = [number("0")] * variable.elements
    for element in description.variables.values():
        is_in_it = element.reference == variable.reference and element.carrier == variable.carrier
        if is_in_it and element.start_text is not None:
            values[element.element] = number(element.start_text.strip())
    return values


def _flat(values: Values) -> Iterator[tuple[str, object]]:
    for name, value in values.items():
        if isinstance(value, Sequence) and not isinstance(value, str):
            yield from _elements(name, cast(Sequence[object], value), ())
        else:
            yield name, value


def _elements(name: str, values: Sequence[object], at: tuple[int, ...]) -> Iterator[tuple[str, object]]:
    for i, value in enumerate(values, start=1):
        here = (*at, i)
        if isinstance(value, Sequence) and not isinstance(value, str):
            yield from _elements(name, cast(Sequence[object], value), here)
        else:
            yield f"{name}[{','.join(map(str, here))}]", value


def _check(variable: FmuVariable, value: object, file: str) -> Scalar:
    who = f"parameters: '{variable.name}' of {file}"
    if variable.kind == "String":
        if not isinstance(value, str):
            raise FmuError(f"{who} is a text, got {value!r}.")
        return value
    if variable.kind == "Boolean":
        if not isinstance(value, bool):
            raise FmuError(f"{who} is true or false, got {value!r}.")
        return value
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise FmuError(f"{who} is a number, got {value!r}.")
    if not math.isfinite(value):
        raise FmuError(f"{who} is a finite number, got {value!r}.")
    if variable.kind != "Real" and value != int(value):
        raise FmuError(f"{who} is a whole number, got {value!r}.")
    unit = f" {variable.unit}" if variable.unit not in ("", "1") else ""
    # A value that was converted may miss a bound that it has to meet by its last digits.
    for bound in (variable.minimum, variable.maximum):
        if bound is not None and math.isclose(value, bound, rel_tol=_ROUNDING, abs_tol=0.0):
            value = bound
    if variable.minimum is not None and value < variable.minimum:
        raise FmuError(f"{who} is at least {variable.minimum:g}{unit}, got {value:g}{unit}.")
    if variable.maximum is not None and value > variable.maximum:
        raise FmuError(f"{who} is at most {variable.maximum:g}{unit}, got {value:g}{unit}.")
    return float(value) if variable.kind == "Real" else int(value)


def _some(description: Description) -> str:
    names = description.names("parameter")
    return ", ".join(names[:12]) + (", …" if len(names) > 12 else "")
