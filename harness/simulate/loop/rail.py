"""What the track does to the train, and what slip does to the track."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import ScenarioError
from railgrip.scenario.adhesion import Profile
from railgrip.scenario.polach import Polach
from railgrip.scenario.profile import Recovery
from railgrip.scenario.track.table import TrackForce
from railgrip.simulate.loop.library import kernel
from railgrip.vehicle.formation import Formation
from railgrip.vehicle.signals import Layout

Vector = NDArray[np.float64]


_CELL = 0.1  # m; beside patches of 5 m and bogies of 2 m; a wheelset meets its own energy only through `loss`


@dataclass(frozen=True, slots=True, kw_only=True)
class Sander:
    """Lays sand on both rails in front of a wheelset.

    Attributes:
        rate: Most sand on one rail [kg/s].
        density: That is kept on one rail while `rate` allows [kg/m]; infinite for a fixed rate.
        begin, end: Of the sand that reaches the rail [s].
        wheelset: Zero-based.
    """

    rate: float
    density: float
    begin: float
    end: float
    wheelset: int


class Field:
    """The energy that slip has left on the rail, cell by cell, and the friction that it wins back.

    A wheel with adhesion force F and slip s dissipates W = F s on each metre of its rail. Where wheels have left the
    sum E and the present one dissipates W, friction is

        f = f_d + λ (max(f_r, f_d) − f_d),   λ = 1 − e^(−τ (E + W)),   f_i = mu0_i ((1 − A_i) e^(−B_i w) + A_i)

    with the slip speed w, f_d of the rail as it lies and f_r of the clean one. So a wheel that slips much gains
    friction itself, and each one behind begins with what those ahead have won. The two wheels of a wheelset share its
    force. A wheelset meets E of its cell as it was when it got there; its own W is added when it leaves.

    Source: Allotta, Meli, Ridolfi and Rindi, Tribology International 69 (2014) 128, and Meccanica 49 (2014) 919, for
    one wheel (E = 0). That E adds up over wheels is that law for a film that does not know which wheel wears it:
    1 − λ = e^(−τ W1) e^(−τ W2).

    Limits: creep stiffness (k_A, k_S) stays that of the rail as it lies, and what a wheel cleans of its own tread is in
    τ. W is that of the sample before.

    Attributes:
        energy: Slip energy left in each cell by the wheelsets that have passed it, per wheel [J/m].
        origin: Where the first cell begins, behind the last wheelset's start [m].
    """

    def __init__(self, layout: Layout, clean: Recovery, falling: Polach, reach: float) -> None:
        """Lay a rail that no wheel has cleaned.

        Args:
            layout: Of the vehicle that runs on it; its formation says where the wheelsets are.
            clean: What slip makes of the rail.
            falling: How the plant's contact lets friction fall.
            reach: How far the train may get [m].
        """
        formation = layout.formation
        position, self.origin, self.energy = _cells(formation, reach)
        self.struct = kernel(layout).struct("Recovery", energy=self.energy, position=position,
            group=np.ascontiguousarray(formation.group_of_wheelset, dtype=np.longlong), origin=self.origin,
            length=_CELL, rate=clean.rate, clean=clean.mu0, clean_A=clean.A, clean_B=clean.B,
            A=[falling.A] * formation.wheelsets, B=[falling.B] * formation.wheelsets, cells=self.energy.size,
        )  # fmt: skip


class SandedRail:
    """Sand on the rail, cell by cell, and the friction that it gives.

    A sander lays d = min(rate / v, density) on each metre of either rail in front of its wheelset at speed v. A
    wheelset that meets d, laid there or left by those ahead, has the friction

        mu0 + (1 − e^(−d / density)) max(mu0_sand − mu0, 0)

    and leaves the share `left` of d to the next one: the rest is crushed, blown away or carried off. So each wheelset
    behind a sander has less of it, and one that stops over its own sand has plenty.

    Friction saturates with the sand on the rail, and most sand misses the contact: Lewis, Riley, Fletcher and Lewis,
    Int. J. Railway Technology 6 (2017) 87, and Proc. IMechE F 232 (2018) 43. That the rest is a constant share, and the
    exponential, are ours.

    Attributes:
        lying: On each cell of either rail, for the wheelsets to come [kg/m].
        origin: Where the first cell begins, behind the last wheelset's start [m].

    Limits: neither rail is wet afterwards, nor does a wheel carry sand around. Creep stiffness and the fall with slip
    speed stay those of the rail as it lies, and sand leaves the nozzle at the rate of the present speed.
    """

    def __init__(
        self, layout: Layout, sanders: Sequence[Sander], reach: float, *, mu0: float, density: float, left: float
    ) -> None:
        """Lay a rail without sand.

        Args:
            layout: Of the vehicle that runs on it; its formation says where the wheelsets are.
            sanders: Who lays it.
            reach: How far the train may get [m].
            mu0: Friction with plenty of sand, at no slip speed.
            density: Sand on a rail that closes 63 % of the gap to `mu0` [kg/m].
            left: Share of it that a wheelset leaves.
        """
        position, self.origin, self.lying = _cells(layout.formation, reach)
        rows = kernel(layout).records("Sander", len(sanders))
        for name in ("rate", "density", "begin", "end", "wheelset"):
            rows[name] = [getattr(sander, name) for sander in sanders]
        self.struct = kernel(layout).struct(
            "Sand", lying=self.lying, position=position, sanders=rows, origin=self.origin, length=_CELL,
            mu0=mu0, density=density, left=left, count=len(sanders), cells=self.lying.size,
        )  # fmt: skip


def _cells(formation: Formation, reach: float) -> tuple[Vector, float, Vector]:
    """Return where wheelsets are, and the first cell begins, of a rail as far as `reach` [m]; and empty cells."""
    position = formation.position
    assert position is not None  # or the friction profile has refused it
    origin = -float(position[-1]) - _CELL
    return position, origin, np.zeros(int((reach - origin) / _CELL) + 2)


class TabulatedRail:
    """Friction and force along the track; the look-up is in `kernel/rail.c`.

    Attributes:
        field: Of the energy that slip leaves; None leaves friction as it lies.
        sand: That sanders lay; None where there are none.
        mu0: Maximum friction at each wheelset, shape (wheelsets,), where the train was last.
        struct: `Rail` of rail.h.
    """

    def __init__(
        self,
        layout: Layout,
        friction: Profile,
        force: TrackForce,
        field: Field | None = None,
        sand: SandedRail | None = None,
        curves: Vector | None = None,
    ) -> None:
        """Lay it under a vehicle of this layout, whose leading wheelset is at distance 0.

        Args:
            layout: Of the vehicle.
            friction: As it lies, and which creep curve lies where.
            force: Of gradient and curve.
            field: Of the energy that slip leaves.
            sand: That sanders lay.
            curves: Polach's k_A, k_S, A and B [s/m] of each creep curve, shape (curves, 4), if there are several.
        """
        self.field, self.sand, self._kernel = field, sand, kernel(layout)
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
        self.struct.set(recovery=field and field.struct, sand=sand and sand.struct)

    def advance(self, time: float, truth: Vector) -> None:
        """Find friction and force at a time with these outputs of the plant, contiguous; times come in order."""
        self._kernel.functions.advance_rail(self.struct.pointer, time, self._kernel.doubles(truth))

    def write_inputs(self, inputs: Vector) -> None:
        """Write the plant's inputs of the rail, contiguous, where the train was last; at first where it starts."""
        self._kernel.functions.write_rail_inputs(self.struct.pointer, self._kernel.doubles(inputs))

    def check_plant(self, truth: Vector) -> None:
        """Refuse a plant that, at its start, does not show what the rail depends on.

        Raises:
            ScenarioError: Slip is to change the rail, and the plant has no adhesion or load of its wheelsets.
        """
        if self.field is not None and any(np.isnan(truth[place]).any() for place in self._energy_places):
            raise ScenarioError(
                "[adhesion.recovery] wants the energy of the slip, and the plant does not show adhesion and "
                "wheelset_load of each wheelset: leave it out, or add these outputs by [vehicle.map]"
            )
