"""What the track does to the train, and what slip does to the track."""

import ctypes
from collections.abc import Sequence
from functools import cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from railgrip.errors import ScenarioError
from railgrip.formation import Formation
from railgrip.loop.library import kernel
from railgrip.signals import Layout

Vector = NDArray[np.float64]


class Profile(Protocol):
    """Friction on an even grid over time or distance, as `railgrip.scenario.adhesion.Profile`."""

    @property
    def over_time(self) -> bool:
        """Whether the grid runs over time [s], else over distance [m]."""
        ...

    @property
    def step(self) -> float:
        """Of the grid."""
        ...

    @property
    def mu0_at(self) -> NDArray[np.float64]:
        """Friction at its points, shape (n, wheelsets)."""
        ...

    @property
    def curve_at(self) -> NDArray[np.uint8] | None:
        """Which creep curve lies there, shape (n, wheelsets); None where there is one."""
        ...


class Sections(Protocol):
    """A force that is constant or straight between places, as `railgrip.scenario.track.TrackForce`."""

    @property
    def begins(self) -> tuple[float, ...]:
        """Where each section begins, the first at −∞ [m]."""
        ...

    @property
    def forces(self) -> tuple[float, ...]:
        """On the train where each section begins, forward positive [N]."""
        ...

    @property
    def rates(self) -> tuple[float, ...]:
        """Change of the force over each section, 0 for the first [N/m]."""
        ...


class Falling(Protocol):
    """How friction falls with slip speed: to the share A, at the rate B [s/m]."""

    @property
    def A(self) -> float:  # noqa: N802 (the name in the literature)
        """Friction at infinite slip speed over that at none."""
        ...

    @property
    def B(self) -> float:  # noqa: N802 (the name in the literature)
        """Decay of friction with slip speed [s/m]."""
        ...


class Clean(Falling, Protocol):
    """The rail once slip has cleaned it, as `railgrip.scenario.profile.Recovery`."""

    @property
    def mu0(self) -> float:
        """Friction at no slip speed."""
        ...

    @property
    def rate(self) -> float:
        """Of the recovery, over the energy of the slip [m/J]."""
        ...


_CELL = 0.1  # m; beside patches of 5 m and bogies of 2 m; a wheelset meets its own energy only through `loss`


@cache
def _structs(wheelsets: int) -> tuple[type[ctypes.Structure], type[ctypes.Structure], type[ctypes.Structure]]:
    """Return the structs `Rail`, `Recovery` and `Sand` of rail.h for so many wheelsets."""

    class Recovery(ctypes.Structure):
        _fields_ = (
            *((name, ctypes.c_void_p) for name in ("energy", "position", "group")),
            *((name, ctypes.c_double) for name in ("origin", "length", "rate")),
            *((name, ctypes.c_double) for name in ("clean", "clean_A", "clean_B")),
            *((name, ctypes.c_double * wheelsets) for name in ("A", "B", "place", "loss", "met", "left")),
            ("cell", ctypes.c_longlong * wheelsets),
            *((name, ctypes.c_longlong) for name in ("cells", "begun")),
        )

    class Sand(ctypes.Structure):
        _fields_ = (
            *((name, ctypes.c_void_p) for name in ("lying", "position", "sanders")),
            *((name, ctypes.c_double) for name in ("origin", "length", "mu0", "density", "left")),
            ("met", ctypes.c_double * wheelsets),
            ("cell", ctypes.c_longlong * wheelsets),
            *((name, ctypes.c_longlong) for name in ("count", "cells", "begun")),
        )

    class Rail(ctypes.Structure):
        _fields_ = (
            *((name, ctypes.c_void_p) for name in ("friction", "curves", "curve_at", "begins", "forces", "rates")),
            *((name, ctypes.c_double) for name in ("grid", "force")),
            ("mu0", ctypes.c_double * wheelsets),
            ("curve", ctypes.c_double * (4 * wheelsets)),
            *((name, ctypes.c_longlong) for name in ("points", "over_time", "sections", "section")),
            *((name, ctypes.c_void_p) for name in ("recovery", "sand")),
        )

    return Rail, Recovery, Sand


class Sander(ctypes.Structure):
    """Who lays sand on both rails in front of a wheelset, as in rail.h.

    Fields: rate, on one rail at most [kg/s]; density that is kept while it allows [kg/m], infinite for a fixed rate;
    begin and end of what comes to the rail [s]; wheelset, from 0 on.
    """

    _fields_ = (
        *((name, ctypes.c_double) for name in ("rate", "density", "begin", "end")),
        ("wheelset", ctypes.c_longlong),
    )


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
    """

    def __init__(self, formation: Formation, clean: Clean, falling: Falling, reach: float) -> None:
        """Lay a rail that no wheel has cleaned.

        Args:
            formation: Whose wheelsets run on it; it says where they are.
            clean: What slip makes of the rail.
            falling: How the plant's contact lets friction fall.
            reach: How far the train may get [m].
        """
        position, self.origin, self.energy = _cells(formation, reach)
        """Of each cell, by the wheelsets that have left it, of one wheel of each [J/m]."""
        self._keep = position, np.ascontiguousarray(formation.group_of_wheelset, dtype=np.longlong)
        self.struct: Any = _structs(formation.wheelsets)[1](
            energy=self.energy.ctypes.data, position=self._keep[0].ctypes.data, group=self._keep[1].ctypes.data,
            origin=self.origin, length=_CELL, rate=clean.rate, clean=clean.mu0, clean_A=clean.A, clean_B=clean.B,
            A=(falling.A,) * formation.wheelsets, B=(falling.B,) * formation.wheelsets, cells=self.energy.size,
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
        self, formation: Formation, sanders: Sequence[Sander], reach: float, *, mu0: float, density: float, left: float
    ) -> None:
        """Lay a rail without sand.

        Args:
            formation: Whose wheelsets run on it; it says where they are.
            sanders: Who lays it.
            reach: How far the train may get [m].
            mu0: Friction with plenty of sand, at no slip speed.
            density: Sand on a rail that closes 63 % of the gap to `mu0` [kg/m].
            left: Share of it that a wheelset leaves.
        """
        position, self.origin, self.lying = _cells(formation, reach)
        each = (Sander * len(sanders))(*sanders)
        self._keep = position, each
        self.struct: Any = _structs(formation.wheelsets)[2](
            lying=self.lying.ctypes.data, position=position.ctypes.data, sanders=ctypes.addressof(each),
            origin=self.origin, length=_CELL, mu0=mu0, density=density, left=left,
            count=len(sanders), cells=self.lying.size,
        )  # fmt: skip


def _cells(formation: Formation, reach: float) -> tuple[Vector, float, Vector]:
    """Return where wheelsets are, and the first cell begins, of a rail as far as `reach` [m]; and empty cells."""
    position = formation.position
    assert position is not None  # or the friction profile has refused it
    origin = -float(position[-1]) - _CELL
    return position, origin, np.zeros(int((reach - origin) / _CELL) + 2)


class TabulatedRail:
    """Friction and force along the track; the look-up is in C (`kernel/rail.c`), for this class as for the loop in C.

    Attributes:
        friction: As it lies.
        sections: Of the force.
        field: Of the energy that slip leaves; None leaves friction as it lies.
        sand: That sanders lay; None where there are none.
        mu0: Maximum friction at each wheelset, shape (wheelsets,), where the train was last.
        curve: Polach's k_A, k_S, A and B [s/m] of the creep curve at each wheelset, shape (4, wheelsets); nothing where
            there is one curve.
        struct: `Rail` of rail.h.
    """

    def __init__(
        self,
        layout: Layout,
        friction: Profile,
        sections: Sections,
        field: Field | None = None,
        sand: SandedRail | None = None,
        curves: Vector | None = None,
    ) -> None:
        """Lay it under a vehicle of this layout, whose leading wheelset is at distance 0.

        Args:
            layout: Of the vehicle.
            friction: As it lies, and which creep curve lies where.
            sections: Of the force.
            field: Of the energy that slip leaves.
            sand: That sanders lay.
            curves: Polach's k_A, k_S, A and B [s/m] of each creep curve, shape (curves, 4), if there are several.
        """
        self.friction, self.sections, self.field, self.sand = friction, sections, field, sand
        self._truth = np.empty(layout.outputs)
        self._roll = kernel(layout).roll
        self._energy_places = [layout.output[name] for name in ("adhesion", "slip", "wheelset_load")]
        self._keep = tuple(
            np.ascontiguousarray(table, dtype=np.float64)
            for table in (friction.mu0_at, sections.begins, sections.forces, sections.rates)
        )
        rail, (lying, *force) = _structs(layout.formation.wheelsets)[0], (table.ctypes.data for table in self._keep)
        self.struct: Any = rail(
            lying, None, None, *force, grid=friction.step, points=len(friction.mu0_at),
            over_time=friction.over_time, sections=len(sections.begins),
        )  # fmt: skip
        self.mu0: Vector = np.ctypeslib.as_array(self.struct.mu0)
        self.curve: Vector = np.ctypeslib.as_array(self.struct.curve).reshape(4, -1)
        if curves is not None and friction.curve_at is not None:
            self._curves = np.ascontiguousarray(curves), np.ascontiguousarray(friction.curve_at)
            self.struct.curves, self.struct.curve_at = (table.ctypes.data for table in self._curves)
        self._sent = [layout.input[signal.name] for signal in layout.sent_signals[1:]]
        self.roll(0.0, np.zeros(layout.outputs))
        if field is not None:
            self.struct.recovery = ctypes.addressof(field.struct)
        if sand is not None:
            self.struct.sand = ctypes.addressof(sand.struct)

    def lay(self, inputs: Vector) -> None:
        """Write what the plant is sent of the rail where the train was last."""
        friction, force, *curve = self._sent
        inputs[friction], inputs[force] = self.mu0, self.force
        for place, values in zip(curve, self.curve, strict=False):
            inputs[place] = values

    @property
    def force(self) -> float:
        """Of gradient and curve on the train where it was last, forward positive [N]."""
        return self.struct.force

    def meet(self, truth: Vector) -> None:
        """Refuse a plant that, at its start, does not show what the rail depends on.

        Raises:
            ScenarioError: Slip is to change the rail, and the plant has no adhesion, slip or load of its wheelsets.
        """
        if self.field is not None and any(np.isnan(truth[place]).any() for place in self._energy_places):
            raise ScenarioError(
                "[adhesion.recovery] wants the energy of the slip, and the plant does not show adhesion, slip and "
                "wheelset_load of each wheelset: leave it out, or add these outputs by [vehicle.map]"
            )

    def roll(self, time: float, truth: Vector) -> None:
        """Find friction and force at a time with these outputs of the plant; times come in order."""
        self._truth[:] = truth
        self._roll(ctypes.addressof(self.struct), time, self._truth.ctypes.data)
