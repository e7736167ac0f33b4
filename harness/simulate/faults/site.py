"""The faults of a stop in the vectors of the loop, and the location of each."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Literal, TypeVar

import numpy as np

from railgrip.base.arrays import Vector
from railgrip.base.errors import ScenarioError
from railgrip.fmus.native.toolchain import Struct
from railgrip.kernel import kernel, rate_of
from railgrip.scenario.faults import Fault
from railgrip.scenario.schema import Scenario
from railgrip.vehicle.signals import Layout

_Kind = TypeVar("_Kind", bound=Fault)

ReadingKind = Literal["dead", "stuck", "scaled", "biased", "noisy"]
CommandKind = Literal["fixed", "kept", "late", "limited"]

FREE = 1.01325e5
"""Absolute pressure at which plants count free air, p_free [Pa]."""


class Faults:
    """All faults of a stop, applied in the order in which they are added.

    Their formulas are in `kernel/faults.c`.

    Attributes:
        struct: `Faults` of faults.h.
    """

    def __init__(self, layout: Layout, *, valves: bool, noise_rate: Fraction | int) -> None:
        """Set up a stop without faults.

        Args:
            layout: Layout of the vectors of the loop.
            valves: Whether commands are valve positions; else they are pressures.
            noise_rate: Number of samples that a draw of noise lasts; less than 1 if the loop skips draws.
        """
        self._kernel = kernel(layout)
        self._rows: dict[str, list[Struct]] = {"reading": [], "command": []}
        self.struct = self._kernel.struct("Faults", valves=valves, noise_rate=rate_of(layout, noise_rate))

    def __bool__(self) -> bool:
        """Return whether there is a fault."""
        return any(self._rows.values())

    def add_reading(
        self, kind: ReadingKind, place: int, *, begin: int, end: int, value: float = 0.0, noise: Vector | None = None
    ) -> None:
        """Change the reading of a sensor while the fault lasts.

        A fault does not create a reading at an instant without one. A dead sensor delivers no new reading; a stuck one
        repeats its last reading, or its first one if nothing was read before.

        Args:
            kind: Kind of fault; noise is drawn before the stop.
            place: Position in the reading vector.
            begin: First sample with the fault.
            end: First sample after it.
            value: Factor, offset, or standard deviation of the noise, the last two in the unit of the reading.
            noise: Sequence of a noisy sensor from `begin` on, with standard deviation 1; it repeats.
        """
        self._add("reading", kind, noise, place=place, begin=begin, end=end, value=value)

    def add_command(
        self, kind: CommandKind, group: int, *, begin: int, end: int, value: float = 0.0, delay: int = 0,
        pressure: float = 0.0, refill: float = 0.0,
    ) -> None:  # fmt: skip
        """Change the command to the brake of a group while the fault lasts.

        Args:
            kind: `fixed` to a value; `kept` as before the fault; `late` by some samples; `limited` by a reservoir that
                empties: its pressure falls isothermally with the air that the plant takes and limits the cylinder
                pressure; a compressor refills it until it is full.
            group: Zero-based group.
            begin: First sample with the fault.
            end: First sample after it.
            value: The fixed command, or the volume of the reservoir [m3].
            delay: Delay in samples.
            pressure: Gauge pressure of the full reservoir [Pa].
            refill: Free air that the compressor delivers per sample [m3].
        """
        ring = np.zeros(delay + 1)
        self._add("command", kind, ring, place=group, begin=begin, end=end, value=value, pressure=pressure,
            free_pressure=FREE, refill=refill,
        )  # fmt: skip

    def _add(self, changed: str, kind: str, ring: Vector | None, **numbers: float) -> None:
        memory = {} if ring is None else {"ring": np.ascontiguousarray(ring), "count": ring.size}
        kind_in_c, rows = getattr(self._kernel.functions, kind.upper()), self._rows[changed]
        rows.append(self._kernel.struct("Fault", kind=kind_in_c, last=math.nan, **numbers, **memory))
        self.struct.set(**{f"{changed}s": self._kernel.array("Fault", rows), f"{changed}_count": len(rows)})


@dataclass(frozen=True, slots=True, kw_only=True)
class Site:
    """The stop that a fault acts on, for as long as the fault lasts.

    Attributes:
        scenario: Scenario of the stop.
        layout: Layout of the vectors of the loop.
        change_reading: `Faults.add_reading` for as long as the fault lasts.
        change_command: `Faults.add_command` for as long as the fault lasts.
        outputs: Names of the plant's outputs.
        valves: Whether the plant takes valve positions; else it takes pressures.
        number: Zero-based number of the fault in the scenario.
    """

    scenario: Scenario
    layout: Layout
    change_reading: Callable[..., None]
    change_command: Callable[..., None]
    outputs: frozenset[str]
    valves: bool
    number: int

    @property
    def where(self) -> str:
        """Opening words of error messages."""
        return f"[faults[{self.number + 1}]]"

    def groups(self, number: int | None) -> range:
        """Return the zero-based groups that the fault affects."""
        return places(number, self.layout.formation.groups, self.where, "group")


def iterate_faults(faults: Sequence[Fault], kind: type[_Kind]) -> Iterator[tuple[str, _Kind]]:
    """Yield the faults of a kind, each with the opening words of its error messages."""
    for number, fault in enumerate(faults, start=1):
        if isinstance(fault, kind):
            yield f"[faults[{number}]]", fault


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


def faults_of(scenario: Scenario, layout: Layout, outputs: frozenset[str]) -> Faults | None:
    """Return the faults between plant, sensors and brakes; None for an intact train.

    Raises:
        ScenarioError: A fault does not fit this vehicle.
    """
    period, valves = scenario.periods.communication, scenario.actuation.kind == "pneumatic"
    every = Fraction(1, 1000) / Fraction(period).limit_denominator(10**9)
    faults = Faults(layout, valves=valves, noise_rate=every)
    for number, fault in enumerate(scenario.faults):
        samples = fault.samples(period, scenario.horizon)
        site = Site(
            scenario=scenario, layout=layout, outputs=outputs, valves=valves, number=number,
            change_reading=partial(faults.add_reading, **samples),
            change_command=partial(faults.add_command, **samples),
        )  # fmt: skip
        fault.act_on(site)
    return faults or None
