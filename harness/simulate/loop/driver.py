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
    """Demands full brake from the first instant on, or follows its phases.

    Distance and speed are those of the plant: a scenario states where an event happens, not where a driver assumes it.
        To stop at a target, the demand is 0 until a = v²/(2 d), with d the remaining distance to the target, reaches
        the deceleration a0 of the curve. Then the demand is the share (a + 2 (a - a0)) / `full_deceleration` of the
        force of full brake, which corrects for a train that decelerates other than expected. Beyond the target it is
        full brake.

    The formulas are in `kernel/driver.c`.

    Attributes:
        struct: `Driver` of driver.h.
        has_phases: Whether it has phases; else it demands full brake.
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
        """Set up the driver of a vehicle.

        Args:
            layout: Layout of the plant's outputs.
            period: Period of the samples [s].
            full: Pressure of full brake, shape (groups,) [Pa].
            touching: Pressure at which pads touch the disc, shape (groups,) [Pa].
            phases: Phases in their order; empty for full brake. Many are faster as an array with the fields of
                `DemandedPhase`.
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
        functions = kernel(layout).functions
        code = {until: getattr(functions, f"AT_{until.upper()}") for until in get_args(EndOfPhase)}
        rows["until"] = [code[until] for until in columns["until"]]
        tables = {name: np.ascontiguousarray(columns[name], dtype=np.float64) for name in ("pressures", "slopes")}
        self.struct = kernel(layout).struct("Driver", phases=rows, count=len(rows), period=period, binding=binding,
            touching=np.array(touching), full=np.array(full), **tables,
        )  # fmt: skip
