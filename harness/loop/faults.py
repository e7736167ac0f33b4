"""Faults between the plant and those who read and command it."""

import ctypes
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from railgrip.loop.library import kernel
from railgrip.signals import Layout

Vector = NDArray[np.float64]

ReadingKind = Literal["dead", "stuck", "scaled", "biased", "noisy"]
CommandKind = Literal["fixed", "kept", "late", "limited"]

FREE = 1.01325e5
"""Absolute pressure at which plants count free air, p_free [Pa]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReadingFault:
    """A sensor that shows something else while the fault lasts.

    What has no new reading has none with a fault, either. A dead sensor shows nothing new, a stuck one what it
    showed last; where it had shown nothing yet, its first reading stands for that.

    Attributes:
        kind: What it does; noise is drawn before the stop.
        place: Of the entry in a reading.
        begin, end: Samples; `end` is the first one without it.
        value: Factor, what is added, or 1σ of what is added, in the unit of the reading.
        noise: Of a noisy one, from `begin` on, of deviation 1; begins anew at its end.
    """

    kind: ReadingKind
    place: int
    begin: int
    end: int
    value: float = 0.0
    noise: Vector | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandFault:
    """What happens to a command on its way to the brake of a group while the fault lasts.

    Attributes:
        kind: `fixed` to a value; `kept` as it was before; `late` by some samples; `limited` by a reservoir that
            empties: its pressure falls with the air that the plant takes, without a change of temperature, and fills
            no cylinder beyond it; a compressor refills it, until it is full.
        group: Zero-based.
        begin, end: Samples; `end` is the first one without it.
        value: The fixed command, or the volume of the reservoir [m3].
        delay: Samples.
        pressure: Of the full reservoir above the atmosphere [Pa].
        refill: Free air that the compressor delivers in a sample [m3].
    """

    kind: CommandKind
    group: int
    begin: int
    end: int
    value: float = 0.0
    delay: int = 0
    pressure: float = 0.0
    refill: float = 0.0


class _Fault(ctypes.Structure):
    _fields_ = (
        *((name, ctypes.c_double) for name in ("value", "pressure", "free", "held", "refill", "refilled")),
        ("past", ctypes.c_void_p),
        *((name, ctypes.c_longlong) for name in ("kind", "place", "begin", "end", "count")),
    )


class _Faults(ctypes.Structure):
    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("readings", "commands")),
        *((name, ctypes.c_longlong) for name in ("reading_count", "command_count", "valves", "noise_every")),
    )


class Faults:
    """All faults of a stop, in C (`kernel/faults.c`) for the Python loop as for that in C."""

    def __init__(
        self,
        layout: Layout,
        readings: Sequence[ReadingFault],
        commands: Sequence[CommandFault],
        *,
        valves: bool,
        noise_every: int,
    ) -> None:
        """Break what they say.

        Args:
            layout: Of the vectors of the loop.
            readings: One after the other, in this order.
            commands: Likewise.
            valves: Commands are positions of valves, else pressures.
            noise_every: Samples that a draw of noise lasts.
        """
        self._keep: list[Any] = []
        of_readings = [
            _Fault(
                kind=get_args(ReadingKind).index(fault.kind), place=fault.place, begin=fault.begin, end=fault.end,
                value=fault.value, held=math.nan, **self._ring(fault.noise),
            )
            for fault in readings
        ]  # fmt: skip
        of_commands = [
            _Fault(
                kind=get_args(CommandKind).index(fault.kind), place=fault.group, begin=fault.begin, end=fault.end,
                value=fault.value, held=math.nan, pressure=fault.pressure, free=FREE, refill=fault.refill,
                **self._ring(np.zeros(fault.delay + 1)),
            )
            for fault in commands
        ]  # fmt: skip
        arrays = [(_Fault * len(of))(*of) for of in (of_readings, of_commands)]
        self._keep += arrays
        self.struct = _Faults(
            readings=ctypes.addressof(arrays[0]), commands=ctypes.addressof(arrays[1]),
            reading_count=len(of_readings), command_count=len(of_commands), valves=valves, noise_every=noise_every,
        )  # fmt: skip
        self._command = np.empty(layout.formation.groups)
        self._truth = np.empty(layout.outputs)
        self._library = kernel(layout)

    def _ring(self, values: Vector | None) -> dict[str, int]:
        if values is None:
            return {}
        self._keep.append(np.ascontiguousarray(values))
        return {"past": self._keep[-1].ctypes.data, "count": values.size}

    def show(self, sample: int, reading: Vector) -> Vector:
        """Return what the sensors show of a reading at a sample; samples come in order."""
        values = np.array(reading, dtype=np.float64)
        self._library.show_faults(ctypes.addressof(self.struct), sample, values.ctypes.data)
        return values

    def transmit(self, sample: int, truth: Vector, commands: Sequence[float]) -> Vector:
        """Return the commands that arrive at the plant, of those sent, at a sample with these outputs of the plant."""
        self._truth[:] = truth
        command = np.array(commands, dtype=np.float64)
        self._library.pass_faults(
            ctypes.addressof(self.struct),
            sample,
            self._truth.ctypes.data,
            command.ctypes.data,
            self._command.ctypes.data,
        )
        return self._command
