"""Parameters that files write with units, in the units of the model that takes them."""

from collections.abc import Mapping

from harness.estimate.error import EstimationError
from harness.scenario.quantity import Magnitude


def in_units(where: str, written: Mapping[str, Magnitude], units: Mapping[str, str]) -> dict[str, float]:
    """Return what a table says in the units of its taker.

    Args:
        where: File and table, to open sentences with.
        written: By name.
        units: Of every name that may be written, as FMI spells them.

    Raises:
        EstimationError: There is no such name, or its unit has another dimension.
    """
    values: dict[str, float] = {}
    for name, magnitude in written.items():
        if name not in units:
            raise EstimationError(f"{where} has no '{name}'; there is {', '.join(units) or 'none'}.")
        try:
            values[name] = magnitude.si(units[name])
        except ValueError as problem:
            raise EstimationError(f"{where} {name} {problem}") from problem
    return values
