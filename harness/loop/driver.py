"""The driver: what brakes and traction are asked for, phase by phase."""

import ctypes
from collections.abc import Sequence
from typing import Any, Literal, Protocol, get_args

import numpy as np
from numpy.typing import NDArray

from railgrip.loop.library import kernel
from railgrip.signals import Layout

Vector = NDArray[np.float64]

Until = Literal["end", "time", "duration", "distance", "speed_below", "speed_above"]
"""What ends a phase, in the order of the enum in driver.h; the last one has no end."""


class Phase(Protocol):
    """What is asked for until something happens, as `railgrip.scenario.demand.DemandedPhase`."""

    @property
    def until(self) -> Until:
        """What ends it."""
        ...

    @property
    def limit(self) -> float:
        """Time or duration [s], distance [m] or speed [m/s] that ends it."""
        ...

    @property
    def begin(self) -> float:
        """Time from which pressures change by their slopes [s]."""
        ...

    @property
    def pressures(self) -> Sequence[float]:
        """Brake cylinder pressure of each group at `begin` [Pa]."""
        ...

    @property
    def slopes(self) -> Sequence[float]:
        """Their change [Pa/s]."""
        ...

    @property
    def target(self) -> float:
        """Distance at which to stop [m]; NaN brakes by the pressures."""
        ...

    @property
    def deceleration(self) -> float:
        """Of the braking curve to the target [m/s²]."""
        ...

    @property
    def full_deceleration(self) -> float:
        """That the driver expects of full brake [m/s²]."""
        ...

    @property
    def force(self) -> float:
        """Most force of the traction [N]."""
        ...

    @property
    def power(self) -> float:
        """Most power of the traction [W]; may be infinite."""
        ...

    @property
    def rate(self) -> float:
        """Most change of the force [N/s]; may be infinite."""
        ...


_NUMBERS = (
    "limit", "begin", "target", "deceleration", "full_deceleration", "force", "power", "rate",
)  # fmt: skip


class _Phase(ctypes.Structure):
    _fields_ = (*((name, ctypes.c_double) for name in _NUMBERS), ("until", ctypes.c_longlong))


def driver_struct(groups: int) -> type[ctypes.Structure]:
    """Return the struct `Driver` of driver.h for so many groups."""

    class Driver(ctypes.Structure):
        _fields_ = (
            *((name, ctypes.c_void_p) for name in ("phases", "pressures", "slopes", "touching", "full")),
            *((name, ctypes.c_double) for name in ("period", "began", "force")),
            ("pressure", ctypes.c_double * groups),
            *((name, ctypes.c_longlong) for name in ("count", "phase", "braking", "binding")),
        )

    return Driver


class Driver:
    """Asks for full brake from the first instant on, or for what its phases say.

    Place and speed are those of the plant: a scenario says where something happens, not where a driver takes it to be.
    To stop at a target, nothing is asked for until a = v²/(2 d), d what is left to the target, reaches the deceleration
    a0 of the curve; from then on the share (a + 2 (a - a0)) / `full_deceleration` of the force of full brake, so that
    what the train does otherwise than expected is made up for on the way. Beyond the target it is full brake.

    The formulas are in C (`kernel/driver.c`), for this class as for the loop in C.

    Attributes:
        has_phases: Whether it asks for anything else than full brake.
        binding: Whether no group is given more than is asked of it; otherwise the controller minds the demand itself.
        pressure: Asked for, shape (groups,) [Pa]; a new array whenever it changes.
    """

    def __init__(
        self,
        layout: Layout,
        period: float,
        *,
        full: Vector,
        touching: Vector,
        phases: Sequence[Phase] | NDArray[np.void] = (),
        binding: bool = True,
    ) -> None:
        """Drive a vehicle of this layout.

        Args:
            layout: Of the plant's outputs.
            period: Of the samples [s].
            full: Pressure of full brake, shape (groups,) [Pa].
            touching: Pressure at which pads begin to press, shape (groups,) [Pa].
            phases: In their order; none for full brake. Many are faster as an array with the fields of `Phase`.
            binding: As the attribute.
        """
        self.has_phases, self.pressure, self.binding = len(phases) > 0, full, binding
        self._truth = np.empty(layout.outputs)
        columns = {
            name: phases[name] if isinstance(phases, np.ndarray) else [getattr(phase, name) for phase in phases]
            for name in (*_NUMBERS, "until", "pressures", "slopes")
        }
        rows: Any = np.empty(len(phases), dtype=np.dtype(_Phase))
        for name in _NUMBERS:
            rows[name] = columns[name]
        code = {until: number for number, until in enumerate(get_args(Until))}
        rows["until"] = [code[until] for until in columns["until"]]
        tables = [np.ascontiguousarray(columns[name], dtype=np.float64) for name in ("pressures", "slopes")]
        self._keep: Any = (rows, *tables, np.array(touching), np.array(full))
        arrays = zip(("pressures", "slopes", "touching", "full"), self._keep[1:], strict=True)
        self.struct: Any = driver_struct(layout.formation.groups)(
            phases=rows.ctypes.data, period=period, count=len(rows), binding=binding,
            **{name: array.ctypes.data for name, array in arrays},
        )  # fmt: skip
        if self.has_phases:
            self._drive = kernel(layout).drive

    @property
    def force(self) -> float:
        """Force of the traction, forward positive [N]."""
        return self.struct.force

    def drive(self, sample: int, truth: Vector) -> None:
        """Ask for what is due at a sample with these outputs of the plant; samples come in order."""
        self._truth[:] = truth
        self._drive(ctypes.addressof(self.struct), sample, self._truth.ctypes.data)
        self.pressure = np.array(self.struct.pressure)
