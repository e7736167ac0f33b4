"""The driver: demanded brake pressures and traction, phase by phase."""

from collections.abc import Sequence
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from railgrip.scenario.demand import DemandedPhase, EndOfPhase
from railgrip.simulate.loop.library import kernel
from railgrip.vehicle.signals import Layout

Vector = NDArray[np.float64]

_NUMBERS = (
    "limit", "begin", "target", "deceleration", "full_deceleration", "force", "power", "rate",
)  # fmt: skip


class Driver:
    """Asks for full brake from the first instant on, or for what its phases say.

    Distance and speed are those of the plant: a scenario says where something happens, not where a driver takes it to
    be. To stop at a target, there is no demand until a = v²/(2 d), with d the distance left to the target, reaches
    the deceleration a0 of the curve; from then on the share (a + 2 (a - a0)) / `full_deceleration` of the force of full
    brake, which corrects for a train that decelerates otherwise than expected. Beyond the target it is full brake.

    The formulas are in `kernel/driver.c`.

    Attributes:
        struct: `Driver` of driver.h.
        has_phases: Whether it asks for anything else than full brake.
        full: Pressure of full brake, shape (groups,) [Pa].
    """

    def __init__(
        self,
        layout: Layout,
        period: float,
        *,
        full: Vector,
        touching: Vector,
        phases: Sequence[DemandedPhase] | NDArray[np.void] = (),
        binding: bool = True,
    ) -> None:
        """Drive a vehicle of this layout.

        Args:
            layout: Of the plant's outputs.
            period: Of the samples [s].
            full: Pressure of full brake, shape (groups,) [Pa].
            touching: Pressure at which pads begin to press, shape (groups,) [Pa].
            phases: In their order; none for full brake. Many are faster as an array with the fields of `DemandedPhase`.
            binding: Whether commands are limited to the driver's demand; else the controller limits itself to it.
        """
        self.has_phases, self.full = len(phases) > 0, full
        columns = {
            name: phases[name] if isinstance(phases, np.ndarray) else [getattr(phase, name) for phase in phases]
            for name in (*_NUMBERS, "until", "pressures", "slopes")
        }
        rows = kernel(layout).records("Phase", len(phases))
        for name in _NUMBERS:
            rows[name] = columns[name]
        code = {until: number for number, until in enumerate(get_args(EndOfPhase))}
        rows["until"] = [code[until] for until in columns["until"]]
        tables = {name: np.ascontiguousarray(columns[name], dtype=np.float64) for name in ("pressures", "slopes")}
        self.struct = kernel(layout).struct("Driver", phases=rows, count=len(rows), period=period, binding=binding,
            touching=np.array(touching), full=np.array(full), **tables,
        )  # fmt: skip
