"""A plant FMU of the library, opened by its recipe's name."""

from collections.abc import Generator, Mapping
from contextlib import contextmanager
from functools import cache

from railgrip.fmu import CoSimulation, Description, Signal, bind, describe
from railgrip.fmus.build import fmu
from railgrip.scenario.quantity import Magnitude, in_units

Edge = Mapping[str, str | tuple[str, int]]
"""Name → unit, or unit and number of elements."""


@contextmanager
def plant(
    name: str, *, inputs: Edge, outputs: Edge, period: float, parameters: Mapping[str, float]
) -> Generator[CoSimulation]:
    """Open a plant FMU of the library, built when it is not up to date.

    Args:
        name: Of the recipe.
        inputs: What it is sent, in the order of the vectors that it is sent.
        outputs: What it shows, in the order of the vectors that come back.
        period: Between communications [s].
        parameters: By FMU variable; the others keep their defaults.

    Raises:
        railgrip.fmu.FmuError: A signal or parameter is not there.
        railgrip.errors.FmuError: The FMU cannot be built.
    """
    description = described(name)
    binding = bind(
        description, inputs=_signals(inputs), outputs=_signals(outputs), parameters=(), table={}, where=f"twin {name}"
    )
    with CoSimulation(description, binding, period=period, parameters=dict(parameters)) as opened:
        yield opened


@cache
def described(name: str) -> Description:
    """Return the description of a plant FMU, built when it is not up to date; asked once in a process."""
    return describe(fmu(name))


def parameters(name: str, written: Mapping[str, Magnitude], where: str) -> dict[str, float]:
    """Return parameters of a plant that a scenario writes, in the plant's units.

    Raises:
        ScenarioError: The plant has no such parameter, or its unit has another dimension.
    """
    units = {v.name: v.unit or v.unit_name for v in described(name).variables.values() if v.causality == "parameter"}
    return in_units(where, written, units)


def defaults(name: str) -> dict[str, float]:
    """Return the numeric parameters of a plant as its class has them."""
    return {
        v.name: float(v.start)
        for v in described(name).variables.values()
        if v.causality == "parameter" and v.kind == "Real" and v.start is not None
    }


def _signals(edge: Edge) -> tuple[Signal, ...]:
    pairs = ((name, (told, 0) if isinstance(told, str) else told) for name, told in edge.items())
    return tuple(Signal(name=name, unit=unit, size=size, needed=True) for name, (unit, size) in pairs)
