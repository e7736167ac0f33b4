"""How slip and sand change the rail: [adhesion.recovery], [adhesion.sand], [[sanders]], and their state in a stop."""

from collections.abc import Sequence
from math import inf
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, StrictInt, model_validator

from railgrip.kernel import kernel
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.table import Delay, Friction, Table, ends_after_it_begins, optional
from railgrip.vehicle.formation import Formation
from railgrip.vehicle.signals import Layout

_CELL = 0.1
"""Length of a cell [m]: short compared with a bogie, of some 2 m, and with patches of friction, of some 5 m.

The effect of a wheelset's own energy, W, does not depend on it.
"""


class Recovery(Table):
    """Cleaning of the rail by slip energy, for the wheel that slips and for those behind it.

    Source: Allotta, Meli, Ridolfi and Rindi, Tribology International 69 (2014) 128; the law is that
    of `SlipEnergy`.
    """

    mu0: Friction = Field(description="maximum friction of the clean rail; where friction is higher it stays")
    A: Annotated[float, UnitRange("1", above=0, at_most=1), Field(description="of the clean rail, as in polach")]
    B: Annotated[float, UnitRange("s/m", at_least=0, at_most=100), Field(description="of the clean rail, as in polach")]
    rate: Annotated[
        float,
        UnitRange("m/J", at_least=0, at_most=1, because="the energy of slip is some 100 J/m to 10 kJ/m of a wheel"),
    ] = Field(description="τ, of the recovery over the energy of the slip of a wheel on a metre of rail")


_Density = Annotated[
    float,
    UnitRange("kg/m", above=0, at_most=1, usual=(1e-4, 0.1), because="a kilogram on a metre of rail is a heap"),
]


class Sand(Table):
    """Effect of sand on the rail: a density d closes the share 1 − e^(−d/density) of the gap of friction to `mu0`."""

    mu0: Friction = Field(
        description="maximum friction of a rail with plenty of sand; where friction is higher it stays"
    )
    density: _Density = Field(description="on one rail, with which 63 % of the gap are closed")
    left: Annotated[float, UnitRange("1", at_least=0, at_most=1)] = Field(
        description="share of what a wheelset meets that is still there for the next one"
    )


class Sander(Table):
    """A pair of nozzles that strew sand on both rails in front of a wheelset."""

    wheelset: Annotated[StrictInt, Field(ge=1, le=256)] = Field(description="in the direction of travel, from 1 on")
    rate: Annotated[
        float,
        UnitRange("kg/s", at_least=1e-6, at_most=1, usual=(1e-3, 0.2), because="sanders lay some kilograms a minute"),
    ] = Field(description="on one rail; of one whose rate varies, the most")
    density: _Density | None = optional("that it keeps on the rail while `rate` allows; without it, `rate`")
    begin: Delay = Field(default=0.0, description="when it is switched on, since the start of the stop")
    end: Delay | None = optional("without it, the end of the stop")
    delay: Annotated[
        float,
        UnitRange("s", at_least=1e-3, at_most=600, or_zero=True, usual=(0.02, 10.0), because="sand falls a metre"),
    ] = Field(description="that sand takes from the box to the rail, after both")

    _in_order = model_validator(mode="after")(ends_after_it_begins)


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

    def __init__(self, layout: Layout, clean: Recovery, falling: tuple[float, float], reach: float) -> None:
        """Create a rail that no wheel has cleaned.

        Args:
            layout: Layout of the vehicle on it; its formation has the positions of the wheelsets.
            clean: Friction of the cleaned rail, and the rate of cleaning.
            falling: A and B [s/m] of the plant's creep curve, the fall of friction with slip speed.
            reach: Distance that the train may cover [m].
        """
        formation = layout.formation
        position, self.origin, self.energy = _cells(formation, reach)
        self.struct = kernel(layout).struct("Recovery", energy=self.energy, position=position,
            group=np.ascontiguousarray(formation.group_of_wheelset, dtype=np.longlong), origin=self.origin,
            length=_CELL, rate=clean.rate, clean=clean.mu0, clean_A=clean.A, clean_B=clean.B,
            A=[falling[0]] * formation.wheelsets, B=[falling[1]] * formation.wheelsets, cells=self.energy.size,
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

    A controller that demands sand, such as `deceleration_control`, switches all sanders within their times.

    Attributes:
        deposited: Sand on each cell of either rail, for the wheelsets to come [kg/m].
        origin: Start of the first cell, behind the last wheelset's initial position [m].
        is_demanded: Whether a controller switches the sanders.

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
        self.is_demanded = False
        rows = kernel(layout).records("Sander", len(sanders))
        for row, sander in zip(rows, sanders, strict=True):
            row["rate"], row["density"] = sander.rate, inf if sander.density is None else sander.density
            row["begin"] = sander.begin + sander.delay
            row["end"] = inf if sander.end is None else sander.end + sander.delay
            row["wheelset"], row["delay"] = sander.wheelset - 1, sander.delay
        self.struct = kernel(layout).struct(
            "Sand", deposited=self.deposited, position=position, sanders=rows, origin=self.origin, length=_CELL,
            mu0=sand.mu0, density=sand.density, remaining_share=sand.left, count=len(sanders),
            cells=self.deposited.size,
        )  # fmt: skip

    def follow(self, demand: NDArray[np.float64]) -> None:
        """Switch the sanders by a controller's demand, shape (1,): on from 0.5 on; it is read at each sample."""
        self.struct.set(is_demanded=demand)
        self.is_demanded = True


def _cells(formation: Formation, reach: float) -> tuple[NDArray[np.float64], float, NDArray[np.float64]]:
    """Return positions of wheelsets, start of the first cell, and zeros for all cells up to one beyond `reach`."""
    position = formation.position
    assert position is not None  # `railgrip.scenario.adhesion.rail_of` requires it
    origin = -float(position[-1]) - _CELL
    return position, origin, np.zeros(int((reach - origin) / _CELL) + 2)
