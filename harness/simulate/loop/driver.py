"""The driver: demanded brake pressures and traction, phase by phase."""

from collections.abc import Sequence
from itertools import cycle
from math import inf, nan
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import ScenarioError
from railgrip.scenario.demand import Demand
from railgrip.simulate.loop.library import kernel
from railgrip.vehicle.signals import Layout

Vector = NDArray[np.float64]
Phases = NDArray[np.void]
"""Structs `Phase` of driver.h."""

_MIN_PRESSURE = 1e3
"""Smallest plausible pressure of a brake cylinder [Pa], far below the 0.2 bar at which pads touch."""


class Driver:
    """Demands full brake from the first instant on, or follows its phases.

    Distance and speed are those of the plant: a scenario states where an event happens, not where a driver assumes it.

    To stop at a target, the demand is 0 until a = v²/(2 d), with d the remaining distance to the target, reaches the
    deceleration a0 of the braking curve. Then it is the share (a + 2 (a - a0)) / `full_deceleration` of the force of
    full brake, which corrects for a train that decelerates other than expected. Beyond the target it is full brake.

    The formulas are in `kernel/driver.c`.

    Attributes:
        struct: `Driver` of driver.h.
        has_phases: Whether it has phases; else it demands full brake.
        full: Pressure of full brake, shape (groups,) [Pa].
    """

    def __init__(
        self, layout: Layout, period: float, *, full: Vector, release_pressure: Vector, phases: Phases | None = None,
        binding: bool = True,
    ) -> None:  # fmt: skip
        """Set up the driver of a vehicle.

        Args:
            layout: Layout of the plant's outputs.
            period: Period of the samples [s].
            full: Pressure of full brake, shape (groups,) [Pa].
            release_pressure: Pressure at which pads touch the disc, shape (groups,) [Pa].
            phases: Phases in their order; None for full brake.
            binding: Whether commands are limited to the driver's demand; else the controller limits itself to it.
        """
        self.has_phases, self.full = phases is not None, full
        rows = released(layout, 0) if phases is None else phases
        self.struct = kernel(layout).struct("Driver", phases=rows, count=len(rows), period=period, binding=binding,
            release_pressure=np.array(release_pressure), full=np.array(full),
        )  # fmt: skip


def released(layout: Layout, count: int) -> Phases:
    """Return `count` phases without brake demand, traction and end."""
    phases = kernel(layout).records("Phase", count)
    for name, value in {"limit": nan, "target": nan, "power": inf, "rate": inf}.items():
        phases[name] = value
    return phases


def phases_of(layout: Layout, demand: Demand, full: Sequence[float], origin: str) -> Phases:
    """Return the phases of a demand.

    Args:
        layout: Layout of the vehicle.
        demand: Table of the scenario.
        full: Pressure of full brake, shape (groups,) [Pa]; pressures are limited to it.
        origin: Name of the scenario, with which messages begin.

    Raises:
        ScenarioError: The demand gives pressures for another number of groups, or above the maximum of a brake.
    """
    if demand.file is not None:
        return _phases_of_profile(layout, demand, full, f"{origin}: [demand] file {demand.file.entry}")
    phases, rate = released(layout, len(demand.phases)), inf
    for number, (row, phase) in enumerate(zip(phases, demand.phases, strict=True), start=1):
        if phase.until is not None:
            row["until"], row["limit"] = _end(layout, phase.until.kind), phase.until.limit
        if phase.pressure is not None:
            row["pressure"] = _of_groups(phase.pressure, full, f"{origin}: [demand.phases[{number}]] pressure")
        if (aim := phase.stop_at) is not None:
            row["target"], row["deceleration"] = aim.distance, aim.deceleration
            row["full_deceleration"] = aim.full_deceleration
        if phase.traction is not None:
            rate = phase.traction.rate or inf  # also of the phases that follow, in which the force falls to 0
            row["force"], row["power"] = phase.traction.force, phase.traction.power or inf
        row["rate"] = rate
    return phases


def _end(layout: Layout, kind: str) -> int:
    return getattr(kernel(layout).functions, f"AT_{kind.upper()}")


def _phases_of_profile(layout: Layout, demand: Demand, full: Sequence[float], where: str) -> Phases:
    # Pressures are linear between points and constant outside.
    columns = demand.profile()
    times, pressures = columns.points, columns.values
    _require_pressures(pressures.shape[1], float(pressures.max()), full, where)
    pressures = np.minimum(pressures, full)
    phases = released(layout, len(times) + 1)
    phases["until"][:-1], phases["limit"][:-1] = _end(layout, "time"), times
    phases["pressure"][0], phases["pressure"][1:] = pressures[0], pressures
    phases["begin"][1:-1] = times[:-1]
    phases["slope"][1:-1] = np.diff(pressures, axis=0) / np.diff(times)[:, None]
    return phases


def _of_groups(entries: Sequence[float | Literal["full"]], full: Sequence[float], where: str) -> list[float]:
    _require_pressures(len(entries), max((entry for entry in entries if entry != "full"), default=0.0), full, where)
    # One entry is for all groups.
    each = zip(cycle(entries), full, strict=False)
    return [limit if entry == "full" else min(float(entry), limit) for entry, limit in each]


def _require_pressures(count: int, highest: float, full: Sequence[float], where: str) -> None:
    if count not in (1, len(full)):
        raise ScenarioError(f"{where} is for {count} groups, the vehicle has {len(full)}")
    if 0.0 < highest < _MIN_PRESSURE:
        raise ScenarioError(
            f"{where} is {highest:g} Pa at most, at which no brake acts (full brake is {max(full):g} Pa); state the "
            "unit: '3 bar' in a scenario, 'pressure [kPa]', [bar] or [psi] in the first line of a file"
        )
    if highest > max(full):
        raise ScenarioError(f"{where} asks for {highest:g} Pa, full brake is {max(full):g} Pa; write 'full'")
