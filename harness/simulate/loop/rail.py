"""The rail: friction and track force, and how slip and sand change friction."""

from collections.abc import Sequence
from math import inf

import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import ScenarioError
from railgrip.scenario.adhesion import FrictionTable
from railgrip.scenario.polach import Polach
from railgrip.scenario.surface import Recovery, Sand, Sander
from railgrip.scenario.track.table import TrackForce
from railgrip.simulate.loop.library import kernel
from railgrip.vehicle.formation import Formation
from railgrip.vehicle.signals import Layout

Vector = NDArray[np.float64]

_CELL = 0.1
"""Length of a cell [m]: short compared with a bogie, of some 2 m, and with patches of friction, of some 5 m.

The effect of a wheelset's own energy, W, does not depend on it.
"""


class SlipEnergy:
    """The slip energy left on the rail, cell by cell, and the friction that it restores.

    A wheel with adhesion force F and slip s dissipates W = F s on each metre of its rail. If earlier wheels have left
    the sum E and the present one dissipates W, friction is

        f = f_d + λ (max(f_r, f_d) − f_d),   λ = 1 − e^(−τ (E + W)),   f_i = mu0_i ((1 − A_i) e^(−B_i w) + A_i)

    with the slip speed w, f_d of the untreated rail and f_r of the clean one. A wheel with high slip thus gains
    friction itself, and each one behind it starts from the friction that those ahead have restored. The two wheels of a
    wheelset share its force. A wheelset uses the E that its cell had when it got there; its own W is added when it
    leaves.

    Source: Allotta, Meli, Ridolfi and Rindi, Tribology International 69 (2014) 128, and Meccanica 49 (2014) 919, for
        one wheel (E = 0). Summing E over wheels is the same law for a film that wears independently of the wheel: 1 − λ
        = e^(−τ W1) e^(−τ W2).

    Limits: creep stiffness (k_A, k_S) stays that of the untreated rail, and the cleaning of a wheel's own tread is
        included in τ. W is that of the previous sample.

    Attributes:
        energy: Slip energy left in each cell by the wheelsets that have passed it, per wheel [J/m].
        origin: Start of the first cell, behind the last wheelset's initial position [m].
    """

    def __init__(self, layout: Layout, clean: Recovery, falling: Polach, reach: float) -> None:
        """Create a rail that no wheel has cleaned.

        Args:
            layout: Layout of the vehicle on it; its formation has the positions of the wheelsets.
            clean: Friction of the cleaned rail, and the rate of cleaning.
            falling: Creep curve of the plant's contact, whose A and B are the fall of friction with slip speed.
            reach: Distance that the train may cover [m].
        """
        formation = layout.formation
        position, self.origin, self.energy = _cells(formation, reach)
        self.struct = kernel(layout).struct("Recovery", energy=self.energy, position=position,
            group=np.ascontiguousarray(formation.group_of_wheelset, dtype=np.longlong), origin=self.origin,
            length=_CELL, rate=clean.rate, clean=clean.mu0, clean_A=clean.A, clean_B=clean.B,
            A=[falling.A] * formation.wheelsets, B=[falling.B] * formation.wheelsets, cells=self.energy.size,
        )  # fmt: skip


class SandedRail:
    """Sand on the rail, cell by cell, and the resulting friction.

    A sander deposits d = min(rate / v, density) on each metre of either rail in front of its wheelset at speed v. A
    wheelset that meets d, deposited there or left by those ahead, has the maximum friction

        mu0 + (1 − e^(−d / density)) max(mu0_sand − mu0, 0)

    and leaves the share `left` of d to the next one: the rest is crushed, blown away or carried off. Each wheelset
    behind a sander thus has less sand, and one that stops over its own sand has plenty.

    Friction saturates with the sand on the rail, and most sand misses the contact: Lewis, Riley, Fletcher and Lewis,
    Int. J. Railway Technology 6 (2017) 87, and Proc. IMechE F 232 (2018) 43. The constant share and the exponential are
    assumptions of this model.

    Attributes:
        deposited: Sand on each cell of either rail, for the wheelsets to come [kg/m].
        origin: Start of the first cell, behind the last wheelset's initial position [m].

    Limits: the rails stay dry, and wheels do not carry sand around. Creep stiffness and the fall with slip speed stay
        those of the untreated rail, and sand leaves the nozzle at the rate of the present speed.
    """

    def __init__(self, layout: Layout, sanders: Sequence[Sander], reach: float, sand: Sand) -> None:
        """Create a rail without sand.

        Args:
            layout: Layout of the vehicle on it; its formation has the positions of the wheelsets.
            sanders: The sanders of the train.
            reach: Distance that the train may cover [m].
            sand: Effect of sand on friction.
        """
        position, self.origin, self.deposited = _cells(layout.formation, reach)
        rows = kernel(layout).records("Sander", len(sanders))
        for row, sander in zip(rows, sanders, strict=True):
            row["rate"], row["density"] = sander.rate, inf if sander.density is None else sander.density
            row["begin"] = sander.begin + sander.delay
            row["end"] = inf if sander.end is None else sander.end + sander.delay
            row["wheelset"] = sander.wheelset - 1
        self.struct = kernel(layout).struct(
            "Sand", deposited=self.deposited, position=position, sanders=rows, origin=self.origin, length=_CELL,
            mu0=sand.mu0, density=sand.density, remaining_share=sand.left, count=len(sanders),
            cells=self.deposited.size,
        )  # fmt: skip


def _cells(formation: Formation, reach: float) -> tuple[Vector, float, Vector]:
    """Return positions of wheelsets, start of the first cell, and zeros for all cells up to one beyond `reach`."""
    position = formation.position
    assert position is not None  # `railgrip.simulate.rail` requires it
    origin = -float(position[-1]) - _CELL
    return position, origin, np.zeros(int((reach - origin) / _CELL) + 2)


class TabulatedRail:
    """Friction and force along the track; the look-up is in `kernel/rail.c`.

    Attributes:
        slip_energy: Slip energy on the rail; None if slip does not change friction.
        sand: Sand on the rail; None without sanders.
        mu0: Maximum friction at each wheelset, shape (wheelsets,), at the last position of the train.
        struct: `Rail` of rail.h.
    """

    def __init__(
        self,
        layout: Layout,
        friction: FrictionTable,
        force: TrackForce,
        slip_energy: SlipEnergy | None = None,
        sand: SandedRail | None = None,
        curves: Vector | None = None,
    ) -> None:
        """Create the rail for a vehicle whose leading wheelset is at distance 0.

        Args:
            layout: Layout of the vehicle.
            friction: Untreated friction, and the creep curve, along the track.
            force: Track force by gradient and curve.
            slip_energy: Slip energy on the rail.
            sand: Sand on the rail.
            curves: Polach's k_A, k_S, A and B [s/m] of each creep curve, shape (curves, 4), if there are several.
        """
        self.slip_energy, self.sand, self._kernel = slip_energy, sand, kernel(layout)
        self._energy_places = [layout.output[name] for name in ("adhesion", "wheelset_load")]
        tables = {"friction": friction.mu0_at, "begins": force.begins, "forces": force.forces, "rates": force.rates}
        self.struct = kernel(layout).struct(
            "Rail", grid=friction.step, points=len(friction.mu0_at), over_time=friction.over_time,
            sections=len(force.begins),
            **{name: np.ascontiguousarray(table, dtype=np.float64) for name, table in tables.items()},
        )  # fmt: skip
        self.mu0 = self.struct.view("mu0")
        if curves is not None and friction.curve_at is not None:
            self.struct.set(curves=np.ascontiguousarray(curves), curve_at=np.ascontiguousarray(friction.curve_at))
        # Where the train starts, before slip or sand have changed anything.
        self.advance(0.0, np.zeros(layout.outputs))
        self.struct.set(recovery=slip_energy and slip_energy.struct, sand=sand and sand.struct)

    def advance(self, time: float, truth: Vector) -> None:
        """Compute friction and force at a time, given the plant's outputs, a contiguous array; times come in order."""
        self._kernel.functions.advance_rail(self.struct.pointer, time, self._kernel.doubles(truth))

    def write_inputs(self, inputs: Vector) -> None:
        """Write the plant's rail inputs to a contiguous array, for the last position of the train.

        Before the first `advance` this is the start.
        """
        self._kernel.functions.write_rail_inputs(self.struct.pointer, self._kernel.doubles(inputs))

    def check_plant(self, truth: Vector) -> None:
        """Raise an error for a plant without the outputs that the rail depends on.

        Raises:
            ScenarioError: Slip changes the rail, and the plant lacks adhesion or load of its wheelsets.
        """
        if self.slip_energy is not None and any(np.isnan(truth[place]).any() for place in self._energy_places):
            raise ScenarioError(
                "[adhesion.recovery] needs the energy of the slip, but the plant does not output adhesion and "
                "wheelset_load of each wheelset: leave it out, or add these outputs by [vehicle.map]"
            )
