"""Location of a scenario's fault in the vectors of the loop."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeVar

from railgrip.base.errors import ScenarioError
from railgrip.scenario.faults import Fault
from railgrip.scenario.schema import Scenario
from railgrip.simulate.loop.faults import Faults
from railgrip.vehicle.brake import Brake
from railgrip.vehicle.signals import Layout

_Kind = TypeVar("_Kind", bound=Fault)


@dataclass(frozen=True, slots=True, kw_only=True)
class Site:
    """The stop that a fault acts on.

    Attributes:
        scenario: Scenario of the stop.
        layout: Layout of the vectors of the loop.
        faults: Faults of single readings and commands, which a fault of the scenario adds to.
        brakes: Nominal brake of each group.
        outputs: Names of the plant's outputs.
        valves: Whether the plant takes valve positions; else it takes pressures.
        number: Zero-based number of the fault in the scenario.
        where: Opening words of error messages.
    """

    scenario: Scenario
    layout: Layout
    faults: Faults
    brakes: Sequence[Brake]
    outputs: frozenset[str]
    valves: bool
    number: int
    where: str

    def groups(self, number: int | None) -> range:
        """Return the zero-based groups that the fault affects."""
        return places(number, self.layout.formation.groups, self.where, "group")


def iterate_faults(scenario: Scenario, kind: type[_Kind]) -> Iterator[tuple[str, _Kind]]:
    """Yield the faults of a kind, each with the opening words of its error messages."""
    for number, fault in enumerate(scenario.faults, start=1):
        if isinstance(fault, kind):
            yield f"{scenario.name}: [faults[{number}]]", fault


def places(number: int | None, count: int, where: str, what: str) -> range:
    """Return the zero-based place of a number that counts from 1; all places if it is None.

    Raises:
        ScenarioError: The number exceeds `count`.
    """
    if number is None:
        return range(count)
    if number > count:
        raise ScenarioError(f"{where} is at {what} {number}, the vehicle has {count}")
    return range(number - 1, number)


def faults_of(
    scenario: Scenario, layout: Layout, brakes: Sequence[Brake], *, outputs: frozenset[str], valves: bool
) -> Faults | None:
    """Return the faults between plant, sensors and brakes; None for an intact train.

    Raises:
        ScenarioError: A fault does not fit this vehicle.
    """
    every = Fraction(1, 1000) / Fraction(scenario.periods.communication).limit_denominator(10**9)
    faults = Faults(layout, valves=valves, noise_rate=every)
    for number, fault in enumerate(scenario.faults):
        fault.act_on(
            Site(
                scenario=scenario, layout=layout, faults=faults, brakes=brakes, outputs=outputs, valves=valves,
                number=number, where=f"{scenario.name}: [faults[{number + 1}]]",
            )
        )  # fmt: skip
    return faults or None
