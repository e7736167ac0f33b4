"""Faults of readings and commands, between the plant and the other parts."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from railgrip.simulate.loop.library import every, kernel
from railgrip.vehicle.signals import Layout

Vector = NDArray[np.float64]

ReadingKind = Literal["dead", "stuck", "scaled", "biased", "noisy"]
CommandKind = Literal["fixed", "kept", "late", "limited"]

FREE = 1.01325e5
"""Absolute pressure at which plants count free air, p_free [Pa]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReadingFault:
    """A sensor whose reading is changed while the fault lasts.

    A fault does not create a reading at an instant without one. A dead sensor delivers no new reading; a stuck one
    repeats its last reading, or its first one if nothing was read before.

    Attributes:
        kind: Kind of fault; noise is drawn before the stop.
        place: Position in the reading vector.
        begin, end: Samples; `end` is the first one without the fault.
        value: Factor, offset, or standard deviation of the noise, the last two in the unit of the reading.
        noise: Sequence of a noisy sensor from `begin` on, with standard deviation 1; it repeats.
    """

    kind: ReadingKind
    place: int
    begin: int
    end: int
    value: float = 0.0
    noise: Vector | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandFault:
    """A change of the command to the brake of a group while the fault lasts.

    Attributes:
        kind: `fixed` to a value; `kept` as before the fault; `late` by some samples; `limited` by a reservoir that
            empties: its pressure falls isothermally with the air that the plant takes and limits the cylinder pressure;
            a compressor refills it until it is full.
        group: Zero-based group.
        begin, end: Samples; `end` is the first one without the fault.
        value: The fixed command, or the volume of the reservoir [m3].
        delay: Delay in samples.
        pressure: Gauge pressure of the full reservoir [Pa].
        refill: Free air that the compressor delivers per sample [m3].
    """

    kind: CommandKind
    group: int
    begin: int
    end: int
    value: float = 0.0
    delay: int = 0
    pressure: float = 0.0
    refill: float = 0.0


class Faults:
    """All faults of a stop; their formulas are in `kernel/faults.c`.

    Attributes:
        struct: `Faults` of faults.h.
    """

    def __init__(
        self,
        layout: Layout,
        readings: Sequence[ReadingFault],
        commands: Sequence[CommandFault],
        *,
        valves: bool,
        noise_every: Fraction | int,
    ) -> None:
        """Set up the faults of a stop.

        Args:
            layout: Layout of the vectors of the loop.
            readings: Faults of readings, applied in this order.
            commands: Faults of commands, applied in this order.
            valves: Whether commands are valve positions; else they are pressures.
            noise_every: Number of samples that a draw of noise lasts; less than 1 if the loop skips draws.
        """
        self._rings: list[Vector] = []
        functions = kernel(layout).functions
        of_readings, of_commands = (kernel(layout).records("Fault", len(faults)) for faults in (readings, commands))
        for row, fault in zip(of_readings, readings, strict=True):
            row["kind"], row["place"] = getattr(functions, fault.kind.upper()), fault.place
            if fault.noise is not None:
                row["past"], row["count"] = self._ring(fault.noise), fault.noise.size
        for row, fault in zip(of_commands, commands, strict=True):
            row["kind"], row["place"] = getattr(functions, fault.kind.upper()), fault.group
            row["pressure"], row["free"], row["refill"] = fault.pressure, FREE, fault.refill
            row["past"], row["count"] = self._ring(np.zeros(fault.delay + 1)), fault.delay + 1
        for rows, faults in ((of_readings, readings), (of_commands, commands)):
            rows["last"] = math.nan
            for name in ("begin", "end", "value"):
                rows[name] = [getattr(fault, name) for fault in faults]
        self.struct = kernel(layout).struct(
            "Faults", readings=of_readings, commands=of_commands, reading_count=len(of_readings),
            command_count=len(of_commands), valves=valves, noise_every=every(layout, noise_every),
        )  # fmt: skip

    def _ring(self, values: Vector) -> int:
        self._rings.append(np.ascontiguousarray(values))
        return self._rings[-1].ctypes.data
